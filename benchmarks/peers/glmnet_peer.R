# glmnet_peer.R DIR THRESHOLD covariance|naive
#
# glmnet at lambdas.npy of a problem that peer_problem wrote. Prints processor
# and wall seconds and writes DIR/coefficients.npy, with fewer columns where
# glmnet stops before the last λ.

suppressPackageStartupMessages(library(glmnet))

# Two-dimensional arrays of float64 in Fortran order, .npy version 1.0.
read_npy <- function(path) {
  file <- file(path, "rb")
  on.exit(close(file))
  readBin(file, "raw", 8)
  length <- readBin(file, "integer", 1, size = 2, signed = FALSE)
  header <- rawToChar(readBin(file, "raw", length))
  shape <- regmatches(header, regexec("\\(([0-9]+), ([0-9]+)\\)", header))[[1]]
  shape <- as.integer(shape[2:3])
  matrix(readBin(file, "double", prod(shape)), shape[1], shape[2])
}

write_npy <- function(values, path) {
  file <- file(path, "wb")
  on.exit(close(file))
  header <- sprintf(
    "{'descr': '<f8', 'fortran_order': True, 'shape': (%d, %d), }",
    nrow(values), ncol(values)
  )
  padding <- 63 - (10 + nchar(header)) %% 64
  header <- paste0(header, strrep(" ", padding), "\n")
  writeBin(as.raw(c(0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0)), file)
  writeBin(nchar(header), file, size = 2)
  writeBin(charToRaw(header), file)
  writeBin(as.vector(values), file)
}

arguments <- commandArgs(trailingOnly = TRUE)
directory <- arguments[1]
x <- read_npy(file.path(directory, "x.npy"))
y <- read_npy(file.path(directory, "y.npy"))[, 1]
lambdas <- read_npy(file.path(directory, "lambdas.npy"))[, 1]
# Deviance ratios near one would end the path before the smallest λ.
glmnet.control(fdev = 0, devmax = 1)
start <- proc.time()
fit <- suppressWarnings(glmnet(
  x, y,
  lambda = lambdas, thresh = as.numeric(arguments[2]), standardize = FALSE,
  intercept = FALSE, maxit = 1e9, type.gaussian = arguments[3]
))
used <- proc.time() - start
cat(sprintf(
  "%.6f %.6f\n", used[["user.self"]] + used[["sys.self"]], used[["elapsed"]]
))
write_npy(as.matrix(fit$beta), file.path(directory, "coefficients.npy"))
