# One-way analysis of variance over the treated conditions of a group (thesis 5.2.1).

analysed <- function(runs) oneway.test(value ~ condition, of_conditions(runs, CONDITIONS), var.equal = TRUE)

anova_f <- function(runs) list(value = analysed(runs)$statistic[[1]])

anova_p <- function(runs) list(value = analysed(runs)$p.value)
