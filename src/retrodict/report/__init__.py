"""How a reconstruction is presented: terminal, figures and documents.

Import the module that is wanted; figures and documents bring matplotlib and jinja2 with them.
"""
