// method FOLDER: a method in C++ that detects: each output's mean distance from
// its set point, at the end of the record, against its spread there.
//
//   g++ -std=c++20 -O2 -o method benchmarks/suite/examples/method.cc
//   benchmarks/suite/run --method='mine=./method' --detects=mine
//
// It leaves model.json as it is. Names in record.csv must have no commas.

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string folder = argv[1];
  std::ifstream record(folder + "/record.csv");
  std::vector<std::string> header;
  std::map<std::string, std::vector<double>> columns;
  for (std::string line; std::getline(record, line);) {
    std::istringstream fields(line);
    std::vector<std::string> row;
    for (std::string field; std::getline(fields, field, ',');) {
      if (!field.empty() && field.back() == '\r') field.pop_back();
      row.push_back(field);
    }
    if (header.empty()) {
      header = row;
      continue;
    }
    for (std::size_t i = 0; i < row.size() && i < header.size(); ++i) {
      columns[header[i]].push_back(row[i].empty() ? std::nan("") : std::atof(row[i].c_str()));
    }
  }
  bool mismatch = false;
  for (const auto& [name, values] : columns) {
    const auto point = columns.find(name + "_setpoint");
    if (point == columns.end()) continue;
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (std::size_t k = values.size() * 9 / 10; k < values.size(); ++k) {
      const double error = values[k] - point->second[k];
      if (std::isnan(error)) continue;
      sum += error, squares += error * error, count += 1.0;
    }
    const double spread = std::sqrt(squares / count - sum * sum / count / count);
    mismatch = mismatch || std::abs(sum / count) > 2.0 * spread;
  }
  std::ofstream(folder + "/decision.txt") << (mismatch ? "mismatch" : "no_change") << "\n";
}
