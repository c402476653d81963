"""Somebody else's ONNX model, run in a sandbox and scored like any other method."""
