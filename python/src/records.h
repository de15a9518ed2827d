// Records: arrays, tables (data frames) and files, as a correction takes them.

#ifndef PYTHON_SRC_RECORDS_H_
#define PYTHON_SRC_RECORDS_H_

#include <memory>
#include <string>
#include <vector>

#include "mle/data/record.h"
#include "mle/data/table_import.h"
#include "pybind11/pybind11.h"

namespace mle::python {

// Where records come from: one of the three.
struct RecordSource {
  std::vector<std::string> paths;
  std::vector<Table> tables;
  std::vector<Record> records;
  // Keeps the arrays that tables refer to. Released with the lock held.
  std::shared_ptr<pybind11::object> keep;
};

// From a tuple (kind, list): ("files", paths), ("tables", tuples as
// python/mle/records.py makes them), ("records", records).
RecordSource SourceOf(const pybind11::tuple& source);

}  // namespace mle::python

#endif  // PYTHON_SRC_RECORDS_H_
