"""What cases/sweep.py is made of, by noun: keywords, scripts, studies, runs, errors, tables, a picture."""
