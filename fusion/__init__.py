"""Features and classifiers for one or several modalities; scikit-learn estimators, no file access."""
