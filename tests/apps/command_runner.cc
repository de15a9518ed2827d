#include "tests/apps/command_runner.h"

#include <cstddef>
#include <cstdlib>

#include "gtest/gtest.h"
#include "mle/base/file.h"

namespace mle {

report::ProcessResult RunCommand(const std::string& command,
                                 const std::vector<std::string>& arguments,
                                 const std::vector<std::string>& variables) {
  std::vector<std::string> line = variables;
  line.push_back(command);
  line.insert(line.end(), arguments.begin(), arguments.end());
  absl::StatusOr<report::ProcessResult> result =
      report::RunProcess("env", line, "");
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *std::move(result)
                     : report::ProcessResult{.exit_code = -1};
}

std::string Content(const std::string& path) {
  const absl::StatusOr<std::string> content = ReadFile(path);
  EXPECT_TRUE(content.ok()) << content.status();
  return content.value_or("");
}

nlohmann::json ParsedJson(const std::string& path) {
  nlohmann::json parsed = nlohmann::json::parse(
      Content(path), /*callback=*/nullptr, /*allow_exceptions=*/false);
  EXPECT_FALSE(parsed.is_discarded()) << path << " is no JSON";
  return parsed;
}

std::vector<std::vector<std::string>> ParsedCsv(const std::string& path) {
  std::vector<std::vector<std::string>> lines;
  std::vector<std::string> fields;
  std::string field;
  bool quoted = false;
  const std::string content = Content(path);
  for (std::size_t i = 0; i < content.size(); ++i) {
    const char c = content[i];
    if (quoted && c == '"' && content.substr(i + 1, 1) == "\"") {
      field += content[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == ',' || c == '\n')) {
      fields.push_back(field);
      field.clear();
      if (c == '\n') {
        lines.push_back(fields);
        fields.clear();
      }
    } else {
      field += c;
    }
  }
  EXPECT_FALSE(quoted) << path << " ends within quotation marks";
  EXPECT_TRUE(fields.empty() && field.empty())
      << path << " does not end with a line's end";
  return lines;
}

std::vector<std::string> SmallRun(const std::string& folder,
                                  const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"--out=" + folder,
                                        "--figures=false",
                                        "--sample_time=0.5",
                                        "--order=30",
                                        "--conversion_duration=2000",
                                        "--duration=400",
                                        "--step_time=200",
                                        "--window=150",
                                        "--response_horizon=60",
                                        "--lambda_grid_step=1e-4"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

}  // namespace mle
