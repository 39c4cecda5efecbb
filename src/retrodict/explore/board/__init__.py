"""The drawing board: a scene file that is made and changed by drawing; `board` is its entry."""
