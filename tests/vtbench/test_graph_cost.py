"""Parameters and multiply-accumulates of graphs whose counts are known by hand."""

from functools import partial

import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper

from fusion.features import get_backbone
from tests.vtbench.run import small
from vtbench.run.choose import Setting
from vtbench.run.fitted import FittedPipeline, fit_pipeline
from vtbench.timing.child import _counted
from vtbench.timing.graph_cost import graph_cost, pipeline_cost


def model(nodes, constants, inputs, output="y"):
    """Graph of nodes (operator, inputs, output, attributes) on float inputs of free batch size."""
    made = [helper.make_node(operator, names, [out], **attributes) for operator, names, out, attributes in nodes]
    declared = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, ["N", *shape[1:]]) for name, shape in inputs.items()
    ]
    held = [numpy_helper.from_array(np.zeros(shape, np.float32), name) for name, shape in constants.items()]
    ends = [helper.make_tensor_value_info(output, TensorProto.FLOAT, None)]
    return helper.make_model(
        helper.make_graph(made, "g", declared, ends, held), opset_imports=[helper.make_opsetid("", 18)]
    )


CASES = {
    # 8 maps of 16 x 16 from 3 channels with 3 x 3 kernels
    "Conv": (("x", "w", "b"), {"w": (8, 3, 3, 3), "b": (8,)}, (1, 3, 16, 16), {"pads": [1] * 4}, 8 * 16 * 16 * 27),
    # every second pixel: a quarter of the outputs
    "Conv, strided": (("x", "w"), {"w": (8, 3, 1, 1)}, (1, 3, 16, 16), {"strides": [2, 2]}, 8 * 8 * 8 * 3),
    # one kernel a channel
    "Conv, depthwise": (("x", "w"), {"w": (4, 1, 3, 3)}, (1, 4, 6, 6), {"group": 4}, 4 * 4 * 4 * 9),
    # each of 4 x 5 x 5 inputs is spread over 2 maps of 2 x 2
    "ConvTranspose": (("x", "w"), {"w": (4, 2, 2, 2)}, (1, 4, 5, 5), {"strides": [2, 2]}, 4 * 25 * 2 * 4),
    "Gemm": (("x", "w", "b"), {"w": (7, 10), "b": (7,)}, (1, 10), {"transB": 1}, 70),
    "MatMul": (("x", "w"), {"w": (10, 7)}, (1, 5, 10), {}, 5 * 70),
    "Relu": (("x",), {}, (1, 10), {}, 0),
}


@pytest.mark.parametrize("case", CASES)
def test_one_operator_counts_as_by_hand(case):
    names, constants, shape, attributes, expected = CASES[case]
    node = (case.partition(",")[0], names, "y", attributes)
    found = graph_cost(model([node], constants, {"x": shape}), {"x": shape})
    assert found.macs == expected
    assert found.params == sum(int(np.prod(size)) for size in constants.values())
    assert found.bytes > 4 * found.params


def test_operators_in_a_row_add_up_and_a_batch_multiplies():
    nodes = [("Gemm", ("x", "w"), "h", {}), ("Relu", ("h",), "r", {}), ("Gemm", ("r", "v"), "y", {})]
    two = model(nodes, {"w": (10, 7), "v": (7, 3)}, {"x": (1, 10)})
    assert graph_cost(two, {"x": (1, 10)}).macs == 70 + 21
    assert graph_cost(two, {"x": (4, 10)}).macs == 4 * (70 + 21)
    with pytest.raises(ValueError, match="input 'x': expected its shape"):
        graph_cost(two, {})


def test_what_only_the_data_decide_is_not_guessed():
    nonzero = [("NonZero", ("x",), "at", {}), ("Cast", ("at",), "f", {"to": 1}), ("MatMul", ("v", "f"), "y", {})]
    assert graph_cost(model(nonzero, {"v": (3, 2)}, {"x": (1, 10)}), {"x": (1, 10)}).macs is None
    branch = model([("MatMul", ("x", "w"), "t", {})], {"w": (10, 7)}, {"x": (1, 10)}, "t").graph
    del branch.input[:]
    either = ("If", ("c",), "y", {"then_branch": branch, "else_branch": branch})
    assert graph_cost(model([either], {"c": (1,)}, {"x": (1, 10)}), {"x": (1, 10)}).macs is None


def test_a_backbone_counts_its_convolutions():
    """Of vt-vgg: 3 x 3 kernels on maps that halve three times, 1 x 1 to the features, one weight a place to pool."""
    found = get_backbone("vt-vgg").onnx_model()
    narrow = 64**2 * 9 * 3 * 24 + 32**2 * 9 * (24 * 48 + 48 * 48)
    wide = 16**2 * 9 * (48 * 96 + 96 * 96) + 8**2 * 9 * (96 * 192 + 192 * 192)
    ends = 8**2 * 192 * 512 + 512 * 8**2
    for side in (128, 256):  # frames of another size are resized first
        assert graph_cost(found, {"images": (1, side, side, 3)}).macs == narrow + wide + ends


def fitted(name, modality=small.FUSED):
    blocks, labels, _ = small.samples()
    method = small.method(name)
    sizes = {"image": 8, "force": None}
    params = {key: values[0] for key, values in method.choices.items()}
    setting = Setting(
        {block.name: sizes[block.name] for block in modality.blocks},
        {block.name: 1.0 for block in modality.blocks},
        params,
    )
    used = {block.name: blocks[block.name] for block in modality.blocks}
    return fit_pipeline(method, modality, setting, used, labels), {name: b.shape[1] for name, b in used.items()}


def test_a_pipeline_counts_from_the_features_on():
    """Eight components of twelve columns are one product; the force is scaled alone, and distances are differences."""
    knn = pipeline_cost(*fitted("knn"))
    assert knn.macs == 12 * 8
    assert knn.params > 60 * (8 + 5), "it keeps every training sample"
    assert pipeline_cost(*fitted("knn", small.FORCE)).macs == 0
    assert pipeline_cost(*fitted("ksc")).macs > pipeline_cost(*fitted("svm")).macs > knn.macs


def test_a_classifier_without_a_graph_counts_nothing_and_fails_nothing():
    pipeline, widths = fitted("Nearest", small.FORCE)
    assert isinstance(pipeline, FittedPipeline)
    assert pipeline_cost(pipeline, widths) is None
    assert _counted(partial(pipeline_cost, pipeline, widths)) is None
    assert _counted(lambda: 1 / 0) is None
    assert _counted(lambda: pipeline_cost(*fitted("svm")))["macs"] > 0
