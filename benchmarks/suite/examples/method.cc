// method FOLDER: a method in C++ that only detects: an output that is further
// from its set point, in the last tenth of the record, than twice its spread.
//
//   g++ -std=c++20 -O2 -o method benchmarks/suite/examples/method.cc
//   benchmarks/suite/run --method='mine=./method' --detects=mine
//
// It leaves model.json as it is. Names in record.csv must have no commas.

#include <cmath>
#include <cstdlib>
#include <fstream>
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
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream fields(line);
    std::vector<std::string> row;
    for (std::string f; std::getline(fields, f, ',');) row.push_back(f);
    for (std::size_t i = 0; i < header.size(); ++i) {
      const bool known = i < row.size() && !row[i].empty();
      columns[header[i]].push_back(known ? std::atof(row[i].c_str()) : NAN);
    }
    if (header.empty()) header = row;
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
    const double mean = sum / count;
    mismatch |= mean * mean > 4.0 * (squares / count - mean * mean);
  }
  std::ofstream(folder + "/decision.txt")
      << (mismatch ? "mismatch\n" : "no_change\n");
}
