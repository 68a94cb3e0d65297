"""A model as one HTML file that any browser plays without a network: `tracks` what it holds, `page` the file,
viewer.html, viewer.css and viewer.js what draws it.
"""
