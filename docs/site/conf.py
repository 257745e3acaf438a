"""Settings of Sphinx for the site that build.py makes."""

project = "pcl_gpu_icp"
extensions = ["myst_parser"]
html_theme = "furo"
html_title = project
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
exclude_patterns = ["docs/site"]
myst_heading_anchors = 4
smartquotes = False  # options start with two dashes
highlight_language = "none"
