# What was measured of a hypothesis: the change of a mean in percent of another, or of a saving in points.

# A change, which is less a saving, with its interval where there is one.
as_change <- function(saving) {
  found <- list(value = -saving$value)
  if (is.null(saving$ci_low)) return(found)
  c(found, saving[c("se", "shared_se", "df")], list(ci_low = -saving$ci_high, ci_high = -saving$ci_low))
}

change <- function(runs) as_change(saving_of(compare(runs, PAIR)))

# The last saving less the first in percentage points.
change_of_saving <- function(runs) as_change(contrast_of(runs, EFFECTS, TRUE))
