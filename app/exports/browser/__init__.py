"""A model as one HTML file that any browser plays without a network: `tracks` what it holds, `page` the file,
viewer.html, viewer.css and the scripts beside them what draws it.
"""
