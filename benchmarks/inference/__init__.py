"""Speed against accuracy: our methods beside what a user would pick instead, on one density.

Every method is measured against a reference posterior that two exact methods agree on.
"""
