#include "collision/xml/xml_element.h"

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "collision/xml/parse_number.h"

namespace cwm::collision {
namespace {

// chosen: the names of robots have a few words; longer ones flood tables.
constexpr std::size_t kMaxNameBytes = 256;
// chosen: the formats in use have some ten per element.
constexpr std::size_t kMaxAttributes = 32;
constexpr std::size_t kMaxTagsAndAttributes = 250'000;  // measured: parsing takes some 20 ms

std::string Owned(std::string_view text) { return std::string(text); }  // for Debian's absl

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

// The length of a UTF-8 sequence, from its first byte; 0 if the byte begins none.
std::size_t SequenceLength(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first < 0xe0) return 2;
  if (first >= 0xe0 && first < 0xf0) return 3;
  if (first >= 0xf0 && first < 0xf5) return 4;
  return 0;
}

// Unicode 15, table 3-7: no overlong forms, no surrogates, nothing beyond U+10FFFF.
bool IsUtf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = SequenceLength(byte(i));
    if (length == 0 || i + length > text.size()) return false;
    for (std::size_t k = 1; k < length; ++k) {
      if ((byte(i + k) & 0xc0) != 0x80) return false;
    }
    if (byte(i) == 0xe0 && byte(i + 1) < 0xa0) return false;
    if (byte(i) == 0xed && byte(i + 1) > 0x9f) return false;
    if (byte(i) == 0xf0 && byte(i + 1) < 0x90) return false;
    if (byte(i) == 0xf4 && byte(i + 1) > 0x8f) return false;
    i += length;
  }
  return true;
}

bool SkipPast(std::string_view end, std::string_view& rest) {
  const std::size_t at = rest.find(end);
  if (at == std::string_view::npos) return false;
  rest.remove_prefix(at + end.size());
  return true;
}

// True if the document has a DOCTYPE, which XML allows only before the root element.
bool HasDoctype(std::string_view rest) {
  if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);
  while (true) {
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n"), rest.size()));
    if (rest.starts_with("<!DOCTYPE")) return true;
    if (rest.starts_with("<?") && SkipPast("?>", rest)) continue;
    if (rest.starts_with("<!--") && SkipPast("-->", rest)) continue;
    return false;
  }
}

// Removes a tag from `rest`, which begins behind its "<", and returns its number of attributes.
std::size_t SkipTag(std::string_view& rest) {
  std::size_t attributes = 0;
  while (true) {
    rest.remove_prefix(std::min(rest.find_first_of("=\"'>"), rest.size()));
    if (rest.empty()) return attributes;
    const char found = rest.front();
    rest.remove_prefix(1);
    if (found == '>') return attributes;
    if (found == '=') ++attributes;
    if ((found == '"' || found == '\'') && !SkipPast({&found, 1}, rest)) rest = {};
  }
}

// Limits the attributes per element: tinyxml2 scans all attributes of an element for each one that
// it reads, and so do its callers.
absl::Status CheckTags(std::string_view rest, std::string_view format) {
  for (std::size_t count = 0; count <= kMaxTagsAndAttributes; ++count) {
    rest.remove_prefix(std::min(rest.find('<'), rest.size()));
    if (rest.empty()) return absl::OkStatus();
    if (rest.starts_with("<!--") && SkipPast("-->", rest)) continue;
    if (rest.starts_with("<![CDATA[") && SkipPast("]]>", rest)) continue;
    if (rest.starts_with("<?") && SkipPast("?>", rest)) continue;
    rest.remove_prefix(1);
    const std::size_t attributes = SkipTag(rest);
    if (attributes > kMaxAttributes) {
      return FaultAt(
          format, absl::StrCat("must have at most ", kMaxAttributes, " attributes in an element"));
    }
    count += attributes;
  }
  return ExcessAt(
      format, absl::StrCat("must have at most ", kMaxTagsAndAttributes, " tags and attributes"));
}

// True if `digits` is the number of a character that XML allows: "945", "x3b1".
bool IsCharacterNumber(std::string_view digits) {
  const bool is_hex = digits.starts_with('x');
  if (is_hex) digits.remove_prefix(1);
  std::uint32_t code = 0;
  const char* const end = digits.data() + digits.size();
  const auto [read, error] = std::from_chars(digits.data(), end, code, is_hex ? 16 : 10);
  if (error != std::errc() || read != end) return false;
  if (code < 0x20) return code == 0x9 || code == 0xa || code == 0xd;
  return code < 0xd800 || (code >= 0xe000 && code <= 0x10ffff && code != 0xfffe && code != 0xffff);
}

// The first reference that is not defined, such as "&arm;"; empty if there is none. Other
// ampersands stand for themselves, because some tools write file names without escaping them.
std::string_view FindUndefined(std::string_view rest) {
  constexpr auto kNameEnds = "; \t\r\n<>&\"'=/?";
  while (true) {
    rest.remove_prefix(std::min(rest.find_first_of("&<"), rest.size()));
    if (rest.empty()) return rest;
    if (rest.starts_with("<!--") && SkipPast("-->", rest)) continue;
    if (rest.starts_with("<![CDATA[") && SkipPast("]]>", rest)) continue;
    if (rest.starts_with("<?") && SkipPast("?>", rest)) continue;
    const bool may_refer = rest.front() == '&';
    rest.remove_prefix(1);
    const std::size_t end = rest.find_first_of(kNameEnds);
    if (!may_refer || end == 0 || end == std::string_view::npos || rest[end] != ';') continue;
    const std::string_view name = rest.substr(0, end);
    const bool is_defined = name.front() == '#' ? IsCharacterNumber(name.substr(1))
                                                : name == "amp" || name == "lt" || name == "gt" ||
                                                      name == "quot" || name == "apos";
    if (!is_defined) return {name.data() - 1, name.size() + 2};
  }
}

// The number of siblings with the same tag on one side. Empty if more siblings than the limit would
// have to be scanned, because a file with many faults needs many places.
template <class Step>
std::optional<int> CountTwins(const tinyxml2::XMLElement& element, Step step) {
  constexpr int kMaxSiblings = 1000;
  int looked_at = 0, twins = 0;
  for (const auto* e = step(element); e != nullptr; e = step(*e)) {
    if (++looked_at > kMaxSiblings) return std::nullopt;
    if (std::string_view(e->Name()) == element.Name()) ++twins;
  }
  return twins;
}

// `: TAG "NAME"`; or `: TAG[INDEX]` if siblings have the same tag; or `: TAG[line 7]` if the
// element has very many siblings.
std::string StepTo(const tinyxml2::XMLElement& element) {
  constexpr std::size_t kMaxTagBytes = 60;
  std::string step = absl::StrCat(": ", std::string(element.Name()).substr(0, kMaxTagBytes));
  if (const char* name = element.Attribute("name"); name != nullptr) {
    absl::StrAppend(&step, " ", Quoted(name));
    return step;
  }
  const auto before = CountTwins(element, [](const auto& e) { return e.PreviousSiblingElement(); });
  const auto after = CountTwins(element, [](const auto& e) { return e.NextSiblingElement(); });
  if (!before.has_value()) {
    absl::StrAppend(&step, "[line ", element.GetLineNum(), "]");
  } else if (*before > 0 || !after.has_value() || *after > 0) {
    absl::StrAppend(&step, "[", *before, "]");
  }
  return step;
}

std::string ParseRule(const tinyxml2::XMLDocument& document) {
  const std::string where = absl::StrCat("line ", document.ErrorLineNum(), ": ");
  switch (document.ErrorID()) {
    case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED:
      return absl::StrCat(where, "elements must not nest deeper than 100");
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      return absl::StrCat(where, "the element is not closed by its own end tag");
    case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
      return "must not be empty";
    default:
      return absl::StrCat(where, "malformed XML (", document.ErrorName(), ")");
  }
}

}  // namespace

std::string_view XmlDocument::WithoutTrailingZeros(std::string_view xml) {
  const std::size_t last = xml.find_last_not_of('\0');
  return xml.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

std::string Quoted(std::string_view text) {
  constexpr std::size_t kMaxShown = 60;  // a line of a terminal, less the rest of the message
  std::string shown(text.substr(0, kMaxShown));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < 0x20 || c > 0x7e; }, '?');
  return absl::StrCat("\"", shown, text.size() > kMaxShown ? "..." : "", "\"");
}

absl::Status FaultAt(std::string_view place, std::string_view rule) {
  return absl::InvalidArgumentError(absl::StrCat(Owned(place), ": ", Owned(rule)));
}

absl::Status ExcessAt(std::string_view place, std::string_view rule) {
  return absl::ResourceExhaustedError(absl::StrCat(Owned(place), ": ", Owned(rule)));
}

std::string_view XmlElement::tag() const { return element_->Name(); }

std::string XmlElement::place() const {
  std::vector<std::string> steps;  // from the element upwards; elements nest at most 100 deep
  const tinyxml2::XMLElement* const root = element_->GetDocument()->RootElement();
  for (const auto* e = element_; e != root; e = e->Parent()->ToElement())
    steps.push_back(StepTo(*e));
  std::string place = *format_;
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) absl::StrAppend(&place, *step);
  return place;
}

absl::Status XmlElement::FaultOf(const char* attribute, std::string_view rule) const {
  const char* value = element_->Attribute(attribute);
  std::string where = place();
  absl::StrAppend(&where, where == *format_ ? ": " : " ", attribute);
  if (value != nullptr) absl::StrAppend(&where, " is ", Quoted(value));
  return FaultAt(where, rule);
}

bool XmlElement::Has(const char* attribute) const {
  return element_->Attribute(attribute) != nullptr;
}

absl::StatusOr<std::string> XmlElement::Text(const char* attribute) const {
  const char* value = element_->Attribute(attribute);
  if (value == nullptr) return FaultOf(attribute, "must be given");
  return std::string(value);
}

absl::StatusOr<std::string> XmlElement::Name(const char* attribute) const {
  absl::StatusOr<std::string> name = Text(attribute);
  if (!name.ok()) return name;
  if (name->empty() || name->size() > kMaxNameBytes || !IsUtf8(*name) ||
      std::any_of(name->begin(), name->end(), IsControl)) {
    return FaultOf(attribute, "must be 1 to 256 bytes of UTF-8 without control characters");
  }
  return name;
}

absl::StatusOr<std::vector<double>> XmlElement::Numbers(const char* attribute,
                                                        std::size_t count) const {
  const absl::StatusOr<std::string> text = Text(attribute);
  if (!text.ok()) return text.status();
  const std::string rule = count == 1 ? std::string("must be a finite number")
                                      : absl::StrCat("must be ", count, " finite numbers");
  std::vector<double> values;
  for (const auto& word : absl::StrSplit(*text, absl::ByAnyChar(" \t\r\n"), absl::SkipEmpty())) {
    const std::optional<double> value = ParseNumber({word.data(), word.size()});
    if (values.size() == count || !value.has_value() || !std::isfinite(*value)) {
      return FaultOf(attribute, rule);
    }
    values.push_back(*value);
  }
  if (values.size() != count) return FaultOf(attribute, rule);
  return values;
}

absl::StatusOr<double> XmlElement::Number(const char* attribute) const {
  const absl::StatusOr<std::vector<double>> values = Numbers(attribute, 1);
  if (!values.ok()) return values.status();
  return values->front();
}

absl::StatusOr<double> XmlElement::NumberOr(const char* attribute, double otherwise) const {
  if (!Has(attribute)) return otherwise;
  return Number(attribute);
}

absl::StatusOr<Vector3> XmlElement::VectorOr(const char* attribute,
                                             const Vector3& otherwise) const {
  if (!Has(attribute)) return otherwise;
  const absl::StatusOr<std::vector<double>> values = Numbers(attribute, 3);
  if (!values.ok()) return values.status();
  return Vector3((*values)[0], (*values)[1], (*values)[2]);
}

absl::StatusOr<std::string_view> XmlElement::Content() const {
  const tinyxml2::XMLNode* only = element_->FirstChild();
  if (only == nullptr) return std::string_view();
  const tinyxml2::XMLText* text = only->ToText();
  if (text == nullptr || text->CData() || only->NextSibling() != nullptr) {
    return Fault("must hold plain text alone");
  }
  return std::string_view(text->Value());
}

std::vector<XmlElement> XmlElement::Children() const {
  std::vector<XmlElement> children;
  for (auto* e = element_->FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    children.emplace_back(*e, *format_);
  }
  return children;
}

std::vector<XmlElement> XmlElement::Children(std::string_view tag) const {
  std::vector<XmlElement> children;
  for (auto* e = element_->FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    if (tag == e->Name()) children.emplace_back(*e, *format_);
  }
  return children;
}

absl::StatusOr<std::optional<XmlElement>> XmlElement::AtMostOne(const char* tag) const {
  std::vector<XmlElement> children = Children(tag);
  if (children.empty()) return std::optional<XmlElement>();
  if (children.size() > 1) {
    return Fault(absl::StrCat("has ", children.size(), " elements <", tag, ">, must have one"));
  }
  return std::optional<XmlElement>(children.front());
}

absl::StatusOr<XmlElement> XmlElement::ExactlyOne(const char* tag) const {
  absl::StatusOr<std::optional<XmlElement>> child = AtMostOne(tag);
  if (!child.ok()) return child.status();
  if (!child->has_value()) return Fault(absl::StrCat("must have an element <", tag, ">"));
  return **std::move(child);
}

XmlDocument::XmlDocument(std::unique_ptr<tinyxml2::XMLDocument> document, std::string format)
    : document_(std::move(document)),
      format_(std::make_unique<const std::string>(std::move(format))) {}
XmlDocument::XmlDocument(XmlDocument&&) noexcept = default;
XmlDocument& XmlDocument::operator=(XmlDocument&&) noexcept = default;
XmlDocument::~XmlDocument() = default;

absl::StatusOr<XmlDocument> XmlDocument::Parse(std::string_view xml, std::string_view format,
                                               std::size_t max_bytes) {
  if (xml.size() > max_bytes) {
    return ExcessAt(format,
                    absl::StrCat("is ", xml.size(), " bytes long, must be at most ", max_bytes));
  }
  if (xml.find('\0') != std::string_view::npos) {  // tinyxml2 would silently stop there
    return FaultAt(format, "must not hold the byte 0");
  }
  if (HasDoctype(xml)) return FaultAt(format, "must not have a DOCTYPE");
  if (absl::Status status = CheckTags(xml, format); !status.ok()) return status;
  auto document = std::make_unique<tinyxml2::XMLDocument>();
  if (document->Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS) {
    return FaultAt(format, ParseRule(*document));
  }
  // tinyxml2 would keep an undefined reference unchanged, as part of a name or a path.
  if (const std::string_view reference = FindUndefined(xml); !reference.empty()) {
    const auto line = 1 + std::count(xml.data(), reference.data(), '\n');
    return FaultAt(format, absl::StrCat("line ", line, ": ", Quoted(reference),
                                        " is not defined: must be &amp;, &lt;, &gt;, &quot;, "
                                        "&apos; or the number of a character, such as &#945;"));
  }
  const tinyxml2::XMLElement* const root = document->RootElement();
  if (root == nullptr) return FaultAt(format, "must have a root element");
  if (const auto* second = root->NextSiblingElement()) {  // tinyxml2 accepts any number of roots
    return FaultAt(format,
                   absl::StrCat("line ", second->GetLineNum(), ": has the root element <",
                                second->Name(), "> beside <", root->Name(), ">, must have one"));
  }
  return XmlDocument(std::move(document), Owned(format));
}

XmlElement XmlDocument::root() const { return {*document_->RootElement(), *format_}; }

}  // namespace cwm::collision
