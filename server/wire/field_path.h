// The path of a value in a request, for errors. A chain of names on the stack that costs nothing
// until an error is made.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace cwm::server {

// Owns neither its name nor its parent. Both must outlive it, as they do if a path is passed down a
// call.
class FieldPath {
 public:
  FieldPath() = default;  // the request itself
  // A field of the request.
  static FieldPath OfRequest(std::string_view name);

  // This path must outlive the result; calls on temporaries do not compile.
  FieldPath Field(std::string_view name) const& { return FieldPath(this, name, kNoIndex); }
  FieldPath Item(std::string_view name, int index) const& { return FieldPath(this, name, index); }
  FieldPath Field(std::string_view name) const&& = delete;
  FieldPath Item(std::string_view name, int index) const&& = delete;

  // E.g. "changes[2].put.object".
  std::string str() const;
  // INVALID_ARGUMENT INVALID_FIELD "<path>: <description>".
  absl::Status Error(std::string description) const;

 private:
  static constexpr int kNoIndex = -1;
  FieldPath(const FieldPath* parent, std::string_view name, int index)
      : parent_(parent), name_(name), index_(index) {}

  const FieldPath* parent_ = nullptr;
  std::string_view name_;
  int index_ = kNoIndex;
};

}  // namespace cwm::server
