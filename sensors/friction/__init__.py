"""Forces of touch that resist penetration and sliding: penalty forms, taxel-pad springs, LuGre friction."""
