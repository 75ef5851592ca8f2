#include "clients/formats/npy_header.h"

#include <charconv>
#include <cstring>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/npy.h"

namespace cwm::formats {
namespace {

constexpr std::size_t kMaxMembers = 256;
constexpr std::size_t kMaxDimensions = 32;  // numpy's limit

// Parses the dictionary, whose tokens are strings, numbers, True, False and brackets.
class PythonLiteralReader {
 public:
  PythonLiteralReader(std::string_view text, std::size_t begin, const std::string& file)
      : text_(text), at_(begin), file_(file) {}

  absl::Status SyntaxError(const std::string& rule) const {
    return FileError(file_, {absl::StrCat("header at byte ", at_),
                             at_ < text_.size() ? std::string(text_.substr(at_, 12)) : "",
                             absl::StrCat("must ", rule)});
  }

  // Consumes the character if it is next.
  bool Skip(char c) {
    SkipBlanks();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  absl::Status Expect(char c) {
    return Skip(c) ? absl::OkStatus()
                   : SyntaxError(absl::StrCat("have ", std::string(1, c), " here"));
  }
  bool AtEnd() {
    SkipBlanks();
    return at_ == text_.size();
  }

  bool IsAtString() {
    SkipBlanks();
    return at_ < text_.size() && (text_[at_] == '\'' || text_[at_] == '"');
  }
  absl::StatusOr<std::string> String() {
    if (!IsAtString()) return SyntaxError("have a string here");
    const std::size_t end = text_.find(text_[at_], at_ + 1);
    if (end == std::string_view::npos) return SyntaxError("end its string");
    const std::string_view inside = text_.substr(at_ + 1, end - at_ - 1);
    if (inside.find('\\') != std::string_view::npos)
      return SyntaxError("have no escapes in strings");
    at_ = end + 1;
    return std::string(inside);
  }

  absl::StatusOr<bool> Truth() {
    SkipBlanks();
    for (const auto& [word, value] :
         {std::pair<std::string_view, bool>{"True", true}, {"False", false}}) {
      if (!text_.substr(at_).starts_with(word)) continue;
      at_ += word.size();
      return value;
    }
    return SyntaxError("have True or False here");
  }

  // "(5, 3)", "(5,)", "()", or a single number.
  absl::StatusOr<std::vector<std::int64_t>> Shape() {
    std::vector<std::int64_t> shape;
    if (!Skip('(')) {
      const auto number = Number();
      if (!number.ok()) return number.status();
      return std::vector<std::int64_t>{*number};
    }
    while (!Skip(')')) {
      if (shape.size() == kMaxDimensions) return SyntaxError("have at most 32 dimensions");
      const auto number = Number();
      if (!number.ok()) return number.status();
      shape.push_back(*number);
      if (Skip(',')) continue;
      if (absl::Status status = Expect(')'); !status.ok()) return status;
      break;
    }
    return shape;
  }

 private:
  void SkipBlanks() {
    while (at_ < text_.size() && std::strchr(" \t\n\r", text_[at_]) != nullptr && text_[at_] != 0) {
      ++at_;
    }
  }

  absl::StatusOr<std::int64_t> Number() {
    SkipBlanks();
    std::int64_t number = 0;
    const auto [end, error] =
        std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
    if (error != std::errc() || number < 0) {
      return SyntaxError("have a number from 0 to 9223372036854775807 here");
    }
    at_ = static_cast<std::size_t>(end - text_.data());
    Skip('L');  // written by Python 2
    return number;
  }

  std::string_view text_;
  std::size_t at_;
  const std::string& file_;
};

absl::StatusOr<NpyMember> ReadMember(PythonLiteralReader& in) {
  NpyMember member;
  if (absl::Status status = in.Expect('('); !status.ok()) return status;
  auto name = in.String();
  if (!name.ok()) return name.status();
  member.name = *std::move(name);
  if (absl::Status status = in.Expect(','); !status.ok()) return status;
  if (!in.IsAtString())
    return in.SyntaxError("have a plain type here, not a structure in a structure");
  auto type = in.String();
  if (!type.ok()) return type.status();
  member.type = *std::move(type);
  if (in.Skip(')')) return member;
  if (absl::Status status = in.Expect(','); !status.ok()) return status;
  if (in.Skip(')')) return member;
  auto shape = in.Shape();
  if (!shape.ok()) return shape.status();
  member.shape = *std::move(shape);
  in.Skip(',');
  if (absl::Status status = in.Expect(')'); !status.ok()) return status;
  return member;
}

absl::Status ReadType(PythonLiteralReader& in, NpyHeader& header) {
  if (in.IsAtString()) {
    auto type = in.String();
    if (!type.ok()) return type.status();
    header.type = *std::move(type);
    return header.type.empty() ? in.SyntaxError("name a type") : absl::OkStatus();
  }
  if (absl::Status status = in.Expect('['); !status.ok()) return status;
  while (!in.Skip(']')) {
    if (header.members.size() == kMaxMembers) return in.SyntaxError("have at most 256 members");
    auto member = ReadMember(in);
    if (!member.ok()) return member.status();
    header.members.push_back(*std::move(member));
    if (in.Skip(',')) continue;
    if (absl::Status status = in.Expect(']'); !status.ok()) return status;
    break;
  }
  return absl::OkStatus();
}

absl::Status ReadEntry(PythonLiteralReader& in, std::set<std::string>& known, NpyHeader& header) {
  const auto key = in.String();
  if (!key.ok()) return key.status();
  if (absl::Status status = in.Expect(':'); !status.ok()) return status;
  if (!known.insert(*key).second) return in.SyntaxError("have each key once");
  if (*key == "descr") return ReadType(in, header);
  if (*key == "fortran_order") {
    const auto truth = in.Truth();
    if (truth.ok()) header.fortran_order = *truth;
    return truth.status();
  }
  if (*key == "shape") {
    auto shape = in.Shape();
    if (!shape.ok()) return shape.status();
    header.shape = *std::move(shape);
    return absl::OkStatus();
  }
  return in.SyntaxError("have the keys descr, fortran_order and shape alone");
}

absl::Status ReadDictionary(PythonLiteralReader& in, NpyHeader& header) {
  if (absl::Status status = in.Expect('{'); !status.ok()) return status;
  std::set<std::string> known;
  while (!in.Skip('}')) {
    if (absl::Status status = ReadEntry(in, known, header); !status.ok()) return status;
    if (in.Skip(',')) continue;
    if (absl::Status status = in.Expect('}'); !status.ok()) return status;
    break;
  }
  if (known.size() != 3) return in.SyntaxError("have had the keys descr, fortran_order and shape");
  return in.AtEnd() ? absl::OkStatus() : in.SyntaxError("end with the dictionary");
}

}  // namespace

absl::StatusOr<NpyHeader> ParseNpyHeader(std::string_view bytes, const std::string& file) {
  if (!bytes.starts_with(kNpyMagic)) {
    return FileError(file, {"first bytes", std::string(bytes.substr(0, 6)), "must be \\x93NUMPY"});
  }
  const std::size_t length_begin = kNpyMagic.size() + 2;
  if (bytes.size() < length_begin) {
    return FileError(file, {"version", "", "is missing: the file ends before it"});
  }
  const int major = static_cast<unsigned char>(bytes[kNpyMagic.size()]);
  if (major < 1 || major > 3) {
    return FileError(file, {"version", absl::StrCat(major), "must be 1, 2 or 3"});
  }
  const std::size_t length_size = major == 1 ? 2 : 4;
  NpyHeader header;
  std::uint32_t length = 0;
  if (bytes.size() >= length_begin + length_size) {
    std::memcpy(&length, bytes.data() + length_begin, length_size);
  }
  const std::size_t begin = length_begin + length_size;
  if (bytes.size() < begin || length > bytes.size() - begin) {
    return FileError(
        file, {"length of the header", absl::StrCat(length),
               absl::StrCat("must be no more than the file of ", bytes.size(), " bytes holds")});
  }
  header.data_begin = begin + length;
  PythonLiteralReader in(bytes.substr(0, header.data_begin), begin, file);
  if (absl::Status status = ReadDictionary(in, header); !status.ok()) return status;
  return header;
}

std::optional<NpyType> NumberType(std::string_view text) {
  static const std::map<std::string_view, Scalar> kTypes = {
      {"i1", Scalar::kI8},  {"u1", Scalar::kU8},  {"i2", Scalar::kI16}, {"u2", Scalar::kU16},
      {"i4", Scalar::kI32}, {"u4", Scalar::kU32}, {"i8", Scalar::kI64}, {"u8", Scalar::kU64},
      {"f4", Scalar::kF32}, {"f8", Scalar::kF64}};
  if (text.empty()) return std::nullopt;
  const char order = text.front();
  const auto found = kTypes.find(text.substr(1));
  if (found == kTypes.end()) return std::nullopt;
  if (order != '<' && order != '>' && !(order == '|' && SizeOf(found->second) == 1)) {
    return std::nullopt;
  }
  return NpyType{found->second, order == '>'};
}

}  // namespace cwm::formats
