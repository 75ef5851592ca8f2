#include "server/wire/field_path.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <utility>

namespace cwm::server {
namespace {

TEST(FieldPath, NamesFieldsAndItemsFromTheRequestOn) {
  const FieldPath request;
  const FieldPath change = request.Item("changes", 2);
  const FieldPath put = change.Field("put");
  EXPECT_EQ(put.Field("object").str(), "changes[2].put.object");
  EXPECT_EQ(request.str(), "");
  EXPECT_EQ(FieldPath::OfRequest("view").str(), "view");
}

TEST(FieldPath, ErrorsNameThePath) {
  const auto status = FieldPath::OfRequest("view").Error("must be shapes or all");
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_EQ(status.message(), "view: must be shapes or all");
}

template <class Path>
concept HasFields = requires(Path&& path) {
  std::forward<Path>(path).Field("name");
};

// The result of a call on a temporary would refer to a path that no longer exists.
TEST(FieldPath, TemporariesHaveNoFields) {
  EXPECT_TRUE(HasFields<const FieldPath&>);
  EXPECT_FALSE(HasFields<FieldPath>);
}

}  // namespace
}  // namespace cwm::server
