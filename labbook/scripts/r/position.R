# Values as at the mean position of their day: a drift over the day is taken off.
# Source: docs/statistics.md, "Order within the day".

# Take slope * (position - mean position of the group's day) off every value. The slope is that of least squares of value
# on position, with a constant for every side of a group's day and for every condition. Its error is one that all values
# share.
at_mean_position <- function(runs) {
  placed <- do.call(rbind, lapply(names(GROUPS), function(group) {
    do.call(rbind, lapply(1:2, function(side) {
      own <- of_conditions(runs, GROUPS[[group]][[side]])
      own$group_day <- paste(group, own$day)
      own$cell <- paste(own$group_day, side)
      own
    }))
  }))
  fit <- summary(lm(value ~ position_in_day + factor(cell) + factor(condition), data = placed))
  slope <- fit$coefficients["position_in_day", ]
  away <- placed$position_in_day - ave(placed$position_in_day, placed$group_day)
  placed$value <- placed$value - slope[["Estimate"]] * away
  error <- matrix(-slope[["Std. Error"]] * away, dimnames = list(NULL, paste0("position|slope|", fit$df[2])))
  placed$shared <- cbind(placed$shared, error)
  placed
}
