"""All queries, by subject: a connection goes in, frozen rows come out; no arithmetic here."""
