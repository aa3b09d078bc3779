# Runs with their values, read from the table beside the script, and printing what was computed.
# A run is a row of a data frame, with its `value`; the matrix `shared` has the signed standard errors that it shares
# with other runs, a column a source, called "fit|term|degrees of freedom". Sources are independent.

read <- function(table) {
  script <- sub("^--file=", "", grep("^--file=", commandArgs(trailingOnly = FALSE), value = TRUE))
  folder <- dirname(gsub("~+~", " ", script, fixed = TRUE)) # R writes a space in its arguments so
  read.csv(file.path(folder, table), stringsAsFactors = FALSE, encoding = "UTF-8",
           colClasses = c(run = "character", day = "character", robot = "character", condition = "character"))
}

of_conditions <- function(runs, conditions) {
  runs[order(match(runs$condition, conditions), na.last = NA), ]
}

# Of several numbers that were computed together the one that is asked for, with the degrees of freedom.
picked <- function(found) c(list(value = found[[PICKED]]), found[intersect("df", names(found))])

show <- function(number) {
  cat(sprintf("%.17g\n", number[["value"]]))
  for (name in setdiff(names(number), "value")) cat(sprintf("%s = %.17g\n", name, number[[name]]))
}
