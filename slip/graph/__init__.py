"""The detectors as ONNX graphs, piece by piece; `slip.onnx` puts them together."""
