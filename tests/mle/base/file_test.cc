#include "mle/base/file.h"

#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FileTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ / name; }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }

  const ScratchFolder folder_;
};

std::string Message(const absl::Status& status) {
  return std::string(status.message());
}

TEST_F(FileTest, WhatIsWrittenIsRead) {
  const std::string contents[] = {"", "one line\n", std::string("\0\xff\r", 3),
                                  std::string(1'000'000, 'x')};
  for (const std::string& content : contents) {
    ASSERT_TRUE(WriteFileAtomically(Path("a"), content).ok());
    const absl::StatusOr<std::string> read = ReadFile(Path("a"));
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(*read, content);
    EXPECT_THAT(Names(), ::testing::ElementsAre("a"));  // Nothing left over.
  }
}

TEST_F(FileTest, MissingFileIsNamed) {
  const absl::Status status = ReadFile(Path("absent")).status();
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
  EXPECT_THAT(Message(status), HasSubstr(Path("absent")));
  EXPECT_THAT(Message(status), HasSubstr("No such file"));
}

TEST_F(FileTest, FoldersAndDevicesAreNotFiles) {
  EXPECT_THAT(Message(ReadFile(folder_.path()).status()),
              HasSubstr("is a folder"));
  EXPECT_THAT(Message(ReadFile("/dev/zero").status()),
              HasSubstr("not a regular file"));
  EXPECT_THAT(Message(WriteFileAtomically(folder_.path(), "x")),
              HasSubstr("is a folder"));
  EXPECT_THAT(Message(WriteFileAtomically("/dev/null", "x")),
              HasSubstr("not a regular file"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(FileTest, PipesAreReadToTheirEnd) {
  const std::string pipe = Path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string content(300'000, 'y');
  std::thread writer([&] { std::ofstream(pipe) << content; });
  const absl::StatusOr<std::string> read = ReadFile(pipe);
  writer.join();
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, content);
}

TEST_F(FileTest, APipeThatNobodyWritesToIsNotWaitedForWithoutAnEnd) {
  const std::string pipe = Path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(Message(ReadFile(pipe).status()), HasSubstr("nobody wrote to"));
}

TEST_F(FileTest, FailedWriteLeavesNothing) {
  const absl::Status status = WriteFileAtomically(Path("no/such/a"), "x");
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
  EXPECT_THAT(Message(status), HasSubstr(Path("no/such/a")));
  EXPECT_TRUE(Names().empty());
  EXPECT_FALSE(WriteFileAtomically("", "x").ok());
}

// Past the limit on the size of a file a write fails part of the way. To be
// called in a child, where the limit does no harm.
[[noreturn]] void WriteBeyondALimit(const std::string& path) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit = {1000, 1000};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const absl::Status status = WriteFileAtomically(path, std::string(5000, 'z'));
  std::_Exit(status.ok() ? 1 : 0);
}

TEST_F(FileTest, FailedWriteKeepsTheOldContent) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "old").ok());
  EXPECT_EXIT(WriteBeyondALimit(Path("a")), ::testing::ExitedWithCode(0), "");
  EXPECT_EQ(*ReadFile(Path("a")), "old");
  EXPECT_THAT(Names(), ::testing::ElementsAre("a"));
}

TEST_F(FileTest, FilesAreWrittenTogetherOrNotAtAll) {
  ASSERT_TRUE(WriteFilesTogether(Path(""), {{"a", "1"}, {"b", "2"}}).ok());
  EXPECT_EQ(*ReadFile(Path("a")), "1");
  EXPECT_EQ(*ReadFile(Path("b")), "2");
  ASSERT_TRUE(fs::create_directory(Path("c")));
  const absl::Status status =
      WriteFilesTogether(Path(""), {{"a", "3"}, {"c", "4"}});
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(Message(status), HasSubstr("is a folder"));
  EXPECT_EQ(*ReadFile(Path("a")), "1");
  EXPECT_THAT(Names(), ::testing::UnorderedElementsAre("a", "b", "c"));
}

// In a name space of its own, where a file system can be mounted upon a file,
// so that it cannot be replaced or removed. Tells by its exit code how it went.
[[noreturn]] void WriteBesideAProtectedFile(const std::string& folder) {
  const std::string b = folder + "b";
  if (::unshare(CLONE_NEWNS) != 0 ||
      ::mount("", "/", "", MS_REC | MS_PRIVATE, nullptr) != 0 ||
      ::mount(b.c_str(), b.c_str(), "", MS_BIND, nullptr) != 0) {
    std::_Exit(2);
  }
  const bool written =
      WriteFilesTogether(folder, {{"a", "3"}, {"new", "4"}, {"b", "5"}}).ok();
  const bool removed =
      WriteFilesTogether(folder, {{"a", "3"}, {"new", "4"}}, {"c", "b"}).ok();
  std::_Exit(written || removed ? 1 : 0);
}

TEST_F(FileTest, OneFileThatCannotBeReplacedKeepsAllOldOnes) {
  ASSERT_TRUE(
      WriteFilesTogether(Path(""), {{"a", "1"}, {"b", "2"}, {"c", "0"}}).ok());
  const pid_t child = ::fork();
  if (child == 0) WriteBesideAProtectedFile(Path(""));
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "nothing can be mounted here";
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(*ReadFile(Path("a")), "1");
  EXPECT_EQ(*ReadFile(Path("b")), "2");
  EXPECT_EQ(*ReadFile(Path("c")), "0");
  EXPECT_THAT(Names(), ::testing::UnorderedElementsAre("a", "b", "c"));
}

TEST_F(FileTest, ObsoleteFilesGoWithTheOldResult) {
  ASSERT_TRUE(WriteFilesTogether(Path(""), {{"a", "1"}, {"b", "2"}}).ok());
  ASSERT_TRUE(WriteFilesTogether(Path(""), {{"a", "3"}}, {"b", "never"}).ok());
  EXPECT_EQ(*ReadFile(Path("a")), "3");
  EXPECT_THAT(Names(), ::testing::ElementsAre("a"));
}

TEST_F(FileTest, WhatIsInTheWayIsNamed) {
  ASSERT_TRUE(WriteFileAtomically(Path("a.json"), "1").ok());
  ASSERT_TRUE(fs::create_directory(Path("runs")));
  EXPECT_TRUE(CheckNothingInTheWay(Path(""), {".json", ".csv"}).ok());
  ASSERT_TRUE(fs::create_directory(Path("b.csv")));
  EXPECT_TRUE(CheckNothingInTheWay(Path(""), {".json"}).ok());
  EXPECT_THAT(Message(CheckNothingInTheWay(Path(""), {".json", ".csv"})),
              HasSubstr("b.csv': it is a folder"));
}

TEST_F(FileTest, LeftoversOfWritersAloneAreRemoved) {
  const std::vector<std::string> kept = {".a.json.tmp", "a.json.12.3.tmp",
                                         ".a.json.12.x.tmp", ".12.3.tmp",
                                         ".a.json.12.3.tmp2"};
  for (const std::string& name : kept) {
    ASSERT_TRUE(WriteFileAtomically(Path(name), "").ok());
  }
  ASSERT_TRUE(WriteFileAtomically(Path(".a.json.12.3.tmp"), "").ok());
  ASSERT_TRUE(WriteFileAtomically(Path(".b.4711.0.tmp"), "").ok());
  RemoveLeftovers(Path(""));
  EXPECT_THAT(Names(), ::testing::UnorderedElementsAreArray(kept));
  RemoveLeftovers(Path("none"));
}

[[noreturn]] void WriteTogetherBeyondALimit(const std::string& folder) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit = {1000, 1000};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const absl::Status status = WriteFilesTogether(
      folder, {{"a", "short"}, {"b", std::string(5000, 'z')}});
  std::_Exit(status.ok() ? 1 : 0);
}

TEST_F(FileTest, OneFileWithoutRoomKeepsAllOldOnes) {
  ASSERT_TRUE(WriteFilesTogether(Path(""), {{"a", "1"}, {"b", "2"}}).ok());
  EXPECT_EXIT(WriteTogetherBeyondALimit(Path("")), ::testing::ExitedWithCode(0),
              "");
  EXPECT_EQ(*ReadFile(Path("a")), "1");
  EXPECT_EQ(*ReadFile(Path("b")), "2");
  EXPECT_THAT(Names(), ::testing::UnorderedElementsAre("a", "b"));
}

TEST_F(FileTest, ManyWritersLeaveOneWholeFile) {
  std::vector<std::thread> writers;
  for (char c = 'a'; c < 'i'; ++c) {
    writers.emplace_back([this, c] {
      for (int repeat = 0; repeat < 5; ++repeat) {
        EXPECT_TRUE(
            WriteFileAtomically(Path("shared"), std::string(50'000, c)).ok());
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  const std::string content = *ReadFile(Path("shared"));
  EXPECT_EQ(content, std::string(50'000, content[0]));
  EXPECT_THAT(Names(), ::testing::ElementsAre("shared"));
}

TEST_F(FileTest, FolderIsMadeWithItsParents) {
  for (int repeat = 0; repeat < 2; ++repeat) {
    const absl::Status status = MakeWritableFolder(Path("a/b/c/"));
    ASSERT_TRUE(status.ok()) << status;
    EXPECT_TRUE(fs::is_directory(Path("a/b/c")));
    EXPECT_TRUE(fs::is_empty(Path("a/b/c")));
  }
}

TEST_F(FileTest, FolderWhereAFileIsFails) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "x").ok());
  EXPECT_THAT(Message(MakeWritableFolder(Path("a"))), HasSubstr(Path("a")));
  EXPECT_THAT(Message(MakeWritableFolder(Path("a/b"))), HasSubstr(Path("a/b")));
  EXPECT_FALSE(MakeWritableFolder("").ok());
}

TEST_F(FileTest, FolderThatTakesNoFilesFails) {
  // No user, not even root, makes files in /proc.
  const absl::Status status = MakeWritableFolder("/proc");
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(Message(status), HasSubstr("cannot make files in"));
}

}  // namespace
}  // namespace mle
