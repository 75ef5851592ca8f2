// Reading the XML of robots: elements that know how one got to them, so that each complaint names
// the place, the value and the rule:
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

// At most 60 printable characters of text in double quotes; everything else becomes '?'.
std::string Quoted(std::string_view text);

// INVALID_ARGUMENT `PLACE: RULE`.
absl::Status FaultAt(std::string_view place, std::string_view rule);
// The same where there is too much of something: RESOURCE_EXHAUSTED.
absl::Status ExcessAt(std::string_view place, std::string_view rule);

// An element of a document, which must outlive it. Two pointers: its place is made when it is asked
// for, since elements are many and complaints few.
class XmlElement {
 public:
  XmlElement(const tinyxml2::XMLElement& element, const std::string& format)
      : element_(&element), format_(&format) {}

  std::string_view tag() const;
  std::string place() const;  // e.g. `urdf: joint "elbow": axis`

  absl::Status Fault(std::string_view rule) const { return FaultAt(place(), rule); }
  // `PLACE ATTRIBUTE is "VALUE": RULE`, or without the value where there is none.
  absl::Status FaultOf(const char* attribute, std::string_view rule) const;

  bool Has(const char* attribute) const;
  // As it stands; refused where absent.
  absl::StatusOr<std::string> Text(const char* attribute) const;
  // 1 to 256 bytes of UTF-8 without control characters: names travel in messages and tables.
  absl::StatusOr<std::string> Name(const char* attribute) const;
  // So many finite numbers with blanks between; `otherwise` where the attribute is absent.
  absl::StatusOr<std::vector<double>> Numbers(const char* attribute, std::size_t count) const;
  absl::StatusOr<double> Number(const char* attribute) const;
  absl::StatusOr<double> NumberOr(const char* attribute, double otherwise) const;
  absl::StatusOr<Vector3> VectorOr(const char* attribute, const Vector3& otherwise) const;

  // The text between its tags; refused where there is anything else. Lives as long as the document.
  absl::StatusOr<std::string_view> Content() const;

  // All element children, or those of a tag, in order. Places carry the child's name, or its index
  // among several of its tag; a tag of more than 60 bytes is cut.
  std::vector<XmlElement> Children() const;
  std::vector<XmlElement> Children(std::string_view tag) const;
  // Refused where there are several.
  absl::StatusOr<std::optional<XmlElement>> AtMostOne(const char* tag) const;
  absl::StatusOr<XmlElement> ExactlyOne(const char* tag) const;

 private:
  const tinyxml2::XMLElement* element_;
  const std::string* format_;  // of the document
};

class XmlDocument {
 public:
  // Refuses malformed XML with its line, anything with a DOCTYPE, references to entities other than
  // the five of XML, elements that nest deeper than 100 or have more than 32 attributes, and documents
  // longer than `max_bytes` or with more than 250,000 tags and attributes: the parser cannot be
  // stopped, and takes some 20 ms for so many. `format` begins every complaint.
  static absl::StatusOr<XmlDocument> Parse(std::string_view xml, std::string_view format,
                                           std::size_t max_bytes);

  XmlDocument(XmlDocument&&) noexcept;
  XmlDocument& operator=(XmlDocument&&) noexcept;
  ~XmlDocument();

  // Its place is the format alone.
  XmlElement root() const;

 private:
  XmlDocument(std::unique_ptr<tinyxml2::XMLDocument> document, std::string format);
  std::unique_ptr<tinyxml2::XMLDocument> document_;
  std::unique_ptr<const std::string> format_;  // elements point to it
};

}  // namespace cwm::collision
