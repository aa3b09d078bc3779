# One-way analysis of variance over the treated conditions of a group (thesis 5.2.1).

analysis_of_variance <- function(runs) {
  found <- oneway.test(value ~ condition, of_conditions(runs, CONDITIONS), var.equal = TRUE)
  list(f = found$statistic[[1]], p = found$p.value)
}
