// How fast a historian's export is read and cut into windows, and what memory
// that takes.
//
//   import_benchmark ROWS numbers|dates FILE.csv
//
// Writes ROWS rows of two inputs, two outputs and their set points to FILE.csv
// in a first process, reads them in a second, and prints seconds and the peak
// of the resident memory of the second.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <iostream>
#include <random>
#include <string>

#include "absl/strings/numbers.h"
#include "glog/logging.h"
#include "mle/data/historian.h"
#include "mle/data/set_point_windows.h"

namespace mle {
namespace {

constexpr int kChangeEvery = 5000;

ProcessModel Model() {
  ProcessModel model("column", "min", {{"reflux", ""}, {"steam", ""}},
                     {{"overhead", ""}, {"bottoms", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(12.8, 16.7, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-18.9, 21.0, 3.0);
  model.element(1, 0) = TransferFunction::FirstOrder(6.6, 10.9, 7.0);
  model.element(1, 1) = TransferFunction::FirstOrder(-19.4, 14.4, 3.0);
  return model;
}

// A sample every 12 s.
void WriteRows(int rows, bool dates, const char* path) {
  std::FILE* file = std::fopen(path, "w");
  CHECK(file != nullptr) << path;
  std::fputs(
      "time,overhead,overhead_setpoint,bottoms,bottoms_setpoint,reflux,steam\n",
      file);
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  double reflux = 0.0;
  double steam = 0.0;
  for (int k = 0; k < rows; ++k) {
    if (k % 5 == 0) {
      reflux = 1e-4 * normal(engine);
      steam = 1e-4 * normal(engine);
    }
    if (dates) {
      const int second = 12 * k;
      const int day = second / 86400;
      // Months of 28 days, and years of twelve of them.
      std::fprintf(file, "%04d-%02d-%02d %02d:%02d:%02d", 2000 + day / 336,
                   1 + day / 28 % 12, 1 + day % 28, second / 3600 % 24,
                   second / 60 % 60, second % 60);
    } else {
      std::fprintf(file, "%.1f", 0.2 * k);
    }
    std::fprintf(file, ",%.6f,%d,%.6f,0,%.8f,%.8f\n", 0.03 * normal(engine),
                 k / kChangeEvery % 2, 0.03 * normal(engine), reflux, steam);
  }
  CHECK_EQ(std::fclose(file), 0);
}

int Read(const char* path) {
  const ProcessModel model = Model();
  const auto start = std::chrono::steady_clock::now();
  const auto import = ImportHistorian({path}, model, HistorianOptions());
  CHECK(import.ok()) << import.status();
  const auto middle = std::chrono::steady_clock::now();
  const auto windows = FindWindows(import->records, model, WindowOptions());
  CHECK(windows.ok()) << windows.status();
  const auto end = std::chrono::steady_clock::now();
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](auto from, auto to) {
    return std::chrono::duration<double>(to - from).count();
  };
  std::cout << import->report.BriefReport() << "\n"
            << windows->windows.size() << " windows\nread "
            << seconds(start, middle) << " s, windows " << seconds(middle, end)
            << " s, peak memory "
            << static_cast<double>(usage.ru_maxrss) / 1024.0 << " MB\n";
  return 0;
}

int Main(int argc, char** argv) {
  int rows = 0;
  if (argc != 4 || !absl::SimpleAtoi(argv[1], &rows) || rows < 2) {
    std::cerr << "import_benchmark ROWS numbers|dates FILE.csv\n";
    return 2;
  }
  const std::string form = argv[2];
  const pid_t writer = fork();
  CHECK_GE(writer, 0);
  if (writer == 0) {
    WriteRows(rows, form == "dates", argv[3]);
    _exit(0);
  }
  int status = 0;
  CHECK_EQ(waitpid(writer, &status, 0), writer);
  CHECK_EQ(status, 0);
  return Read(argv[3]);
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) { return mle::Main(argc, argv); }
