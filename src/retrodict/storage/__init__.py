"""What is kept on disk: whole files, archives, rows of an unfinished study, interrupted chains."""
