"""The report of a study: sections, tables, figures."""
