// Reads the XML files of robots. An element knows its path in the document, so that each error
// names the place, the value and the rule:
//   urdf: joint "elbow": axis xyz is "0 0 0": must have positive length
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "collision/geometry/pose.h"

namespace tinyxml2 {
class XMLDocument;
class XMLElement;
}  // namespace tinyxml2

namespace cwm::collision {

// At most 60 characters of text in double quotes, with "?" for each that is not printable.
std::string Quoted(std::string_view text);

// INVALID_ARGUMENT `PLACE: RULE`.
absl::Status FaultAt(std::string_view place, std::string_view rule);
// RESOURCE_EXHAUSTED `PLACE: RULE`, for an input that exceeds a limit.
absl::Status ExcessAt(std::string_view place, std::string_view rule);

// An element of a document, which must outlive it. It holds two pointers; its place is computed on
// demand, since elements are many and errors few.
class XmlElement {
 public:
  XmlElement(const tinyxml2::XMLElement& element, const std::string& format)
      : element_(&element), format_(&format) {}

  std::string_view tag() const;
  std::string place() const;  // e.g. `urdf: joint "elbow": axis`

  absl::Status Fault(std::string_view rule) const { return FaultAt(place(), rule); }
  // `PLACE ATTRIBUTE is "VALUE": RULE`, without the value if the attribute is absent.
  absl::Status FaultOf(const char* attribute, std::string_view rule) const;

  bool Has(const char* attribute) const;
  // The unchanged value; refused if the attribute is absent.
  absl::StatusOr<std::string> Text(const char* attribute) const;
  // A name of 1 to 256 bytes of UTF-8 without control characters, because names appear in messages
  // and tables.
  absl::StatusOr<std::string> Name(const char* attribute) const;
  // Exactly `count` finite numbers separated by blanks. NumberOr and VectorOr return `otherwise` if
  // the attribute is absent.
  absl::StatusOr<std::vector<double>> Numbers(const char* attribute, std::size_t count) const;
  absl::StatusOr<double> Number(const char* attribute) const;
  absl::StatusOr<double> NumberOr(const char* attribute, double otherwise) const;
  absl::StatusOr<Vector3> VectorOr(const char* attribute, const Vector3& otherwise) const;

  // The text between the tags; refused if there is anything else. It lives as long as the document.
  absl::StatusOr<std::string_view> Content() const;

  // The child elements, all or those with a given tag, in document order. A child's place has its
  // name, or its index if several siblings have the same tag; tags are cut to 60 bytes.
  std::vector<XmlElement> Children() const;
  std::vector<XmlElement> Children(std::string_view tag) const;
  // Refused if there are several.
  absl::StatusOr<std::optional<XmlElement>> AtMostOne(const char* tag) const;
  absl::StatusOr<XmlElement> ExactlyOne(const char* tag) const;

 private:
  const tinyxml2::XMLElement* element_;
  const std::string* format_;  // of the document
};

class XmlDocument {
 public:
  // The document without zero bytes at its end, which some programs write after the text.
  static std::string_view WithoutTrailingZeros(std::string_view xml);

  // Parses a document. Refuses malformed XML, with its line; a DOCTYPE; references to entities
  // other than the five of XML; elements that nest deeper than 100 or have more than 32 attributes;
  // and documents longer than `max_bytes` or with more than 250,000 tags and attributes, because
  // the parser cannot be interrupted and takes some 20 ms for that many. Every error begins with
  // `format`.
  static absl::StatusOr<XmlDocument> Parse(std::string_view xml, std::string_view format,
                                           std::size_t max_bytes);

  XmlDocument(XmlDocument&&) noexcept;
  XmlDocument& operator=(XmlDocument&&) noexcept;
  ~XmlDocument();

  // The root element, whose place is the format alone.
  XmlElement root() const;

 private:
  XmlDocument(std::unique_ptr<tinyxml2::XMLDocument> document, std::string format);
  std::unique_ptr<tinyxml2::XMLDocument> document_;
  std::unique_ptr<const std::string> format_;  // elements point to it
};

}  // namespace cwm::collision
