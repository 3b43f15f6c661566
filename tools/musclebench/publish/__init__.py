"""Tables, figures and quoted numbers of README and reports, written from the results of named runs."""
