"""The report of a study: tables and figures, as a page and as a document."""
