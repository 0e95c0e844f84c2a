"""What report.py is made of: run_folder reads what a run has left, figures and movie draw it, sections tell it, page makes one HTML file."""
