#include "perception/object_notes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cwm::perception {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(NotesByKind, NamesEachKindOnceWithItsObjects) {
  EXPECT_THAT(NotesByKind({}), IsEmpty());
  EXPECT_THAT(NotesByKind({{3, "coarse"}}), ElementsAre("object 3: coarse"));
  EXPECT_THAT(NotesByKind({{9, "coarse"}, {2, "cut"}, {1, "coarse"}, {4, "coarse"}, {9, "coarse"}}),
              ElementsAre("objects 1, 4 and 9: coarse", "object 2: cut"));
}

TEST(NotesByKind, CountsTheObjectsThatItDoesNotList) {
  std::vector<ObjectNote> notes;
  for (std::size_t k = 1; k <= 9; ++k) notes.emplace_back(k, "coarse");
  EXPECT_THAT(NotesByKind(notes), ElementsAre("objects 1, 2, 3, 4, 5, 6, 7, 8 and 9: coarse"));
  for (std::size_t k = 10; k <= 20; ++k) notes.emplace_back(k, "coarse");
  EXPECT_THAT(NotesByKind(notes),
              ElementsAre("objects 1, 2, 3, 4, 5, 6, 7, 8 and 12 more: coarse"));
}

TEST(NotesByKind, LeavesOutObjectsThatAreNoMore) {
  EXPECT_THAT(NotesByKind({{0, "coarse"}}), ElementsAre("coarse"));
  EXPECT_THAT(NotesByKind({{0, "coarse"}, {5, "coarse"}}), ElementsAre("object 5: coarse"));
}

}  // namespace
}  // namespace cwm::perception
