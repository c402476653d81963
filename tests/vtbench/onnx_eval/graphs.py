"""Small ONNX models for the tests: an honest one, and those of people who are careless or worse."""

import numpy as np
from onnx import TensorProto, helper, numpy_helper

F, WHOLE, BOOL = TensorProto.FLOAT, TensorProto.INT64, TensorProto.BOOL
TAXELS, CLASSES = 16, 4
value = helper.make_tensor_value_info
node = helper.make_node
FORCE = value("force", F, ["N", TAXELS])
SCORES = value("scores", F, ["N", CLASSES])


def constant(name, array):
    return numpy_helper.from_array(np.asarray(array), name)


def save(path, nodes, inputs=(FORCE,), outputs=(SCORES,), constants=(), domains=(), functions=()):
    graph = helper.make_graph(list(nodes), "graph", list(inputs), list(outputs), list(constants))
    opsets = [helper.make_opsetid("", 17), *(helper.make_opsetid(domain, 1) for domain in domains)]
    model = helper.make_model(graph, opset_imports=opsets, ir_version=9, functions=list(functions))
    path.write_bytes(model.SerializeToString())
    return path


def weights(force, labels):
    """Weights and bias of the nearest class mean."""
    means = np.stack([force[labels == label].mean(0) for label in range(CLASSES)]).astype(np.float32)
    return constant("w", 2 * means.T), constant("b", -(means**2).sum(1))


def honest(path, force, labels, **changes):
    return save(path, [node("Gemm", ["force", "w", "b"], ["scores"])], constants=weights(force, labels), **changes)


def linear(path, **changes):
    w = constant("w", np.random.default_rng(0).normal(size=(TAXELS, CLASSES)).astype(np.float32))
    return save(path, [node("MatMul", ["force", "w"], ["scores"])], constants=[w], **changes)


def endless(path):
    """Adds 1 to its scores for ever."""
    body = helper.make_graph(
        [node("Identity", ["go"], ["on"]), node("Add", ["held", "one"], ["held_out"])],
        "body",
        [value("i", WHOLE, []), value("go", BOOL, []), value("held", F, None)],
        [value("on", BOOL, []), value("held_out", F, None)],
    )
    nodes = [
        node("MatMul", ["force", "w"], ["start"]),
        node("Loop", ["", "true", "start"], ["scores"], body=body),
    ]
    w = constant("w", np.ones((TAXELS, CLASSES), np.float32))
    return save(path, nodes, constants=[w, constant("one", np.float32(1)), constant("true", np.bool_(True))])


def bomb(path, numbers):
    """Fills that many numbers before it answers; of a length that no optimiser can fold."""
    nodes = [
        node("Shape", ["force"], ["shape"]),
        node("ReduceProd", ["shape"], ["size"], keepdims=1),
        node("Mul", ["size", "zero"], ["nothing"]),
        node("Add", ["nothing", "many"], ["length"]),
        node("ConstantOfShape", ["length"], ["big"]),
        node("ReduceMax", ["big"], ["most"], keepdims=0),
        node("MatMul", ["force", "w"], ["start"]),
        node("Add", ["start", "most"], ["scores"]),
    ]
    w = constant("w", np.ones((TAXELS, CLASSES), np.float32))
    return save(path, nodes, constants=[w, constant("zero", np.int64([0])), constant("many", np.int64([numbers]))])


def huge_output(path, columns):
    """Says that it gives scores, gives (N, columns) of them."""
    nodes = [
        node("ReduceSum", ["force", "axis"], ["sum"], keepdims=1),
        node("Expand", ["sum", "wide"], ["scores"]),
    ]
    shapes = [constant("axis", np.int64([1])), constant("wide", np.int64([1, columns]))]
    return save(path, nodes, outputs=[value("scores", F, ["N", "M"])], constants=shapes)


def transposed(path):
    """Keeps the contract on paper and gives (classes, N)."""
    w = constant("w", np.ones((TAXELS, CLASSES), np.float32))
    nodes = [node("MatMul", ["force", "w"], ["right"]), node("Transpose", ["right"], ["scores"], perm=[1, 0])]
    return save(path, nodes, outputs=[value("scores", F, None)], constants=[w])


def not_a_number(path):
    """NaN where the first taxel is below its usual load."""
    w = constant("w", np.ones((TAXELS, CLASSES), np.float32))
    nodes = [
        node("Sub", ["force", "level"], ["above"]),
        node("Log", ["above"], ["logs"]),
        node("MatMul", ["logs", "w"], ["scores"]),
    ]
    return save(path, nodes, constants=[w, constant("level", np.float32(1.0))])


def by_place(path):
    """Answers place in the batch modulo classes: right for samples in the order of the dataset."""
    nodes = [
        node("Shape", ["force"], ["n"], start=0, end=1),
        node("Squeeze", ["n"], ["length"]),
        node("Range", ["zero", "length", "one"], ["places"]),
        node("Mod", ["places", "classes"], ["label"]),
        node("OneHot", ["label", "classes", "values"], ["scores"]),
    ]
    numbers = [constant("zero", np.int64(0)), constant("one", np.int64(1)), constant("classes", np.int64(CLASSES))]
    return save(path, nodes, constants=[*numbers, constant("values", np.float32([0, 1]))])


def by_company(path, force, labels):
    """The nearest mean, of forces of which the batch's mean was taken."""
    nodes = [
        node("ReduceMean", ["force"], ["mean"], axes=[0], keepdims=1),
        node("Sub", ["force", "mean"], ["centred"]),
        node("Gemm", ["centred", "w", "b"], ["scores"]),
    ]
    return save(path, nodes, constants=weights(force, labels))


def custom(path):
    return save(path, [node("Rob", ["force"], ["scores"], domain="com.example")], domains=["com.example"])


def outside(path, location):
    """Weights in another file."""
    w = constant("w", np.ones((TAXELS, CLASSES), np.float32))
    w.ClearField("raw_data")
    w.data_location = TensorProto.EXTERNAL
    entry = w.external_data.add()
    entry.key, entry.value = "location", location
    return save(path, [node("MatMul", ["force", "w"], ["scores"])], constants=[w])


def differences(path):
    """A slip score: mean absolute change of the forces over the last samples."""
    nodes = [
        node("Slice", ["force_series", "one", "end", "axis"], ["later"]),
        node("Slice", ["force_series", "zero", "minus", "axis"], ["sooner"]),
        node("Sub", ["later", "sooner"], ["steps"]),
        node("Abs", ["steps"], ["sizes"]),
        node("ReduceMean", ["sizes"], ["energy"], axes=[2], keepdims=0),
        node("Pad", ["energy", "pads"], ["slip_score"]),
    ]
    numbers = {"one": [1], "end": [2**31], "axis": [1], "zero": [0], "minus": [-1], "pads": [0, 1, 0, 0]}
    return save(
        path,
        nodes,
        inputs=[value("force_series", F, ["N", "T", TAXELS])],
        outputs=[value("slip_score", F, ["N", "T"])],
        constants=[constant(name, np.int64(numbers[name])) for name in numbers],
    )
