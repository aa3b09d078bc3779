# Holm's adjusted p (Holm 1979) of one test among those of its family; tests that have no p count all the same.

adjusted <- function(p_values) p.adjust(p_values, "holm", n = length(p_values) + WITHOUT_P)[[ASKED]]

adjusted_p <- function(runs) {
  list(value = adjusted(vapply(TESTS, function(pair) p_of(compare(runs, pair)), 0)))
}

adjusted_p_of_contrast <- function(runs) {
  list(value = adjusted(vapply(CONTRASTS, function(test) contrast_of(runs, test[[2]], test[[1]])$p, 0)))
}
