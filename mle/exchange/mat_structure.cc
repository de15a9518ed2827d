#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "mle/exchange/mat_file.h"
#include "mle/exchange/mat_variables.h"

namespace mle {
namespace {

constexpr std::size_t kHeaderBytes = 128;
// Kinds of elements, and classes of arrays, of the format.
constexpr std::uint32_t kMatrix = 14;
constexpr std::uint32_t kCompressed = 15;
constexpr std::uint32_t kCell = 1;
constexpr std::uint32_t kCharacters = 4;
constexpr std::uint32_t kSparse = 5;
constexpr std::uint32_t kLastNumber = 15;
// Beyond, a variable is not one of a model.
constexpr std::size_t kMostInflated = std::size_t{1} << 28;
constexpr int kDeepest = 8;

struct Element {
  std::uint32_t kind = 0;
  std::string_view content;
};

class Walk {
 public:
  explicit Walk(bool little) : little_(little) {}

  bool AreVariablesWhole(std::string_view bytes) const {
    while (!bytes.empty()) {
      const std::optional<Element> element = Take(bytes, /*padded=*/false);
      if (!element.has_value() || !IsVariableWhole(*element)) return false;
    }
    return true;
  }

 private:
  std::uint32_t Word(std::string_view bytes) const {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto byte = static_cast<unsigned char>(bytes[k]);
      word |= static_cast<std::uint32_t>(byte) << 8 * (little_ ? k : 3 - k);
    }
    return word;
  }

  // The next element, taken off the bytes. Small ones have their size in the
  // upper half of the kind; within arrays the others are padded to 8 bytes.
  std::optional<Element> Take(std::string_view& bytes, bool padded) const {
    if (bytes.size() < 8) return std::nullopt;
    std::uint32_t kind = Word(bytes);
    if (const std::size_t small = kind >> 16; small != 0) {
      if (small > 4) return std::nullopt;
      const Element element = {kind & 0xffff, bytes.substr(4, small)};
      bytes.remove_prefix(8);
      return element;
    }
    const std::size_t size = Word(bytes.substr(4));
    bytes.remove_prefix(8);
    if (size > bytes.size()) return std::nullopt;
    const Element element = {kind, bytes.substr(0, size)};
    const std::size_t whole = padded ? (size + 7) / 8 * 8 : size;
    bytes.remove_prefix(std::min(whole, bytes.size()));
    return element;
  }

  bool IsVariableWhole(const Element& element) const {
    if (element.kind == kMatrix) return IsArrayWhole(element.content, 0);
    if (element.kind != kCompressed) return true;
    const std::optional<std::string> inflated = Inflate(element.content);
    if (!inflated.has_value()) return false;
    std::string_view rest = *inflated;
    const std::optional<Element> inner = Take(rest, /*padded=*/true);
    return inner.has_value() && inner->kind == kMatrix &&
           IsArrayWhole(inner->content, 0);
  }

  static std::optional<std::string> Inflate(std::string_view bytes) {
    std::string inflated(std::max<std::size_t>(16 * bytes.size(), 4096), '\0');
    z_stream stream = {};
    if (inflateInit(&stream) != Z_OK) return std::nullopt;
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    int state = Z_OK;
    while (state == Z_OK && inflated.size() <= kMostInflated) {
      if (stream.total_out == inflated.size()) {
        inflated.resize(2 * inflated.size());
      }
      stream.next_out =
          reinterpret_cast<Bytef*>(inflated.data() + stream.total_out);
      stream.avail_out = static_cast<uInt>(inflated.size() - stream.total_out);
      state = inflate(&stream, Z_NO_FLUSH);
    }
    inflated.resize(stream.total_out);
    inflateEnd(&stream);
    if (state != Z_STREAM_END) return std::nullopt;
    return inflated;
  }

  // Flags, sizes, name, and then what the class of the array has.
  bool IsArrayWhole(std::string_view bytes, int depth) const {
    if (bytes.empty()) return true;
    const std::optional<Element> flags = Take(bytes, /*padded=*/true);
    const std::optional<Element> sizes = Take(bytes, /*padded=*/true);
    const std::optional<Element> name = Take(bytes, /*padded=*/true);
    if (!flags.has_value() || !sizes.has_value() || !name.has_value() ||
        flags->content.size() < 4 || depth > kDeepest) {
      return false;
    }
    const std::uint32_t kind = Word(flags->content) & 0xff;
    const bool has_entries =
        kind == kCell ||
        (kind >= kCharacters && kind <= kLastNumber && kind != kSparse);
    // Models have none of the others.
    if (!has_entries) return true;
    std::size_t entries = 1;
    for (std::size_t at = 0; at + 4 <= sizes->content.size(); at += 4) {
      const std::size_t size = Word(sizes->content.substr(at));
      // An entry takes a byte at least.
      if (size > 0 && entries > bytes.size() / size) return false;
      entries *= size;
    }
    return kind == kCell ? AreCellsWhole(bytes, entries, depth) : true;
  }

  bool AreCellsWhole(std::string_view bytes, std::size_t count,
                     int depth) const {
    for (std::size_t c = 0; c < count; ++c) {
      const std::optional<Element> cell = Take(bytes, /*padded=*/true);
      if (!cell.has_value() || cell->kind != kMatrix ||
          !IsArrayWhole(cell->content, depth + 1)) {
        return false;
      }
    }
    return true;
  }

  bool little_;
};

}  // namespace

// A header of 128 bytes, which says in which order bytes stand, and then
// elements: kind, size in bytes, content.
bool IsWholeMatFile(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes || !IsMatFile(bytes)) return false;
  const Walk walk(bytes.substr(126, 2) == "IM");
  return walk.AreVariablesWhole(bytes.substr(kHeaderBytes));
}

}  // namespace mle
