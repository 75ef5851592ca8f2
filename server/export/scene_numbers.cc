#include "server/export/scene_numbers.h"

#include <charconv>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace cwm::server {

std::string NumberText(double value) {
  char bytes[32];  // the longest shortest representation has 24 characters
  const auto [end, error] = std::to_chars(bytes, bytes + sizeof(bytes), value + 0.0);  // no -0
  std::string text(bytes, end);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return text;
}

std::string Text(const Vector3& vector, const char* separator) {
  return absl::StrCat(NumberText(vector.x()), separator, NumberText(vector.y()), separator,
                      NumberText(vector.z()));
}

std::string RotationText(const Pose& pose, const char* separator) {
  Quaternion q(pose.linear());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return absl::StrCat(NumberText(q.x()), separator, NumberText(q.y()), separator, NumberText(q.z()),
                      separator, NumberText(q.w()));
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') quoted += '\\';
    if (byte < 0x20 || byte == 0x7f) {
      absl::StrAppendFormat(&quoted, "\\x%02x", byte);
    } else {
      quoted += c;  // bytes of UTF-8 stay as they are
    }
  }
  return quoted + "\"";
}

}  // namespace cwm::server
