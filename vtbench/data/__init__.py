"""Datasets on disk: format, writer, reader, importers, public recordings."""
