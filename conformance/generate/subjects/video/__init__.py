"""Codecs: configurations, records and samples. Clause 10."""
