"""From an analysis to what a report shows; the only place that knows both."""
