"""What is drawn: the figures of the report, and what they are drawn with."""
