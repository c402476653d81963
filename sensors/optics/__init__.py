"""From a deformed skin to the frame that the camera sees."""
