// Where in a request a value stands, for errors. A chain of names on the stack: costs nothing until
// an error is made.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace cwm::server {

// Does not own its names nor its parent: both outlive it, as they do when a path is passed down a
// call.
class FieldPath {
 public:
  FieldPath() = default;  // the request itself
  // A field of the request.
  static FieldPath OfRequest(std::string_view name);

  // This path outlives what it returns, and no temporary does: such a call does not compile.
  FieldPath Field(std::string_view name) const& { return FieldPath(this, name, kNoIndex); }
  FieldPath Item(std::string_view name, int index) const& { return FieldPath(this, name, index); }
  FieldPath Field(std::string_view name) const&& = delete;
  FieldPath Item(std::string_view name, int index) const&& = delete;

  // "changes[2].put.object"
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
