"""Crashes of cars whose wheels roll, with a truth of their own: are they answered, rightly and soon?"""
