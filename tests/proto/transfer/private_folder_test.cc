#include "proto/transfer/private_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "tests/support/other_user.h"
#include "tests/support/process.h"

namespace cwm {
namespace {

using ::testing::HasSubstr;

class PrivateFolder : public ::testing::Test {
 protected:
  void MakeFolder(mode_t mode) {
    mkdir(path_.c_str(), 0700);
    ASSERT_EQ(chmod(path_.c_str(), mode), 0);  // whatever the umask is
  }
  void ExpectRefused(const absl::Status& status, const std::string& why) const {
    EXPECT_TRUE(absl::IsPermissionDenied(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(path_ + ": " + why));
  }

  const testing::ScratchDirectory scratch_;
  const std::string path_ = scratch_ / "folder";
};

TEST_F(PrivateFolder, IsMadeForThisUserAlone) {
  EXPECT_TRUE(absl::IsNotFound(CheckFolder(path_, FolderRule::kPrivate)));
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(MakePrivateFolder(path_).ok());
  struct stat info {};
  ASSERT_EQ(lstat(path_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777, 0700U);
  EXPECT_EQ(info.st_uid, getuid());
}

TEST_F(PrivateFolder, GivesGroupAndOthersNothing) {
  for (const mode_t mode : {0710U, 0740U, 0701U, 0704U, 0720U, 0777U, 01777U}) {
    MakeFolder(mode);
    ExpectRefused(MakePrivateFolder(path_), "has mode ");
  }
  MakeFolder(0755);
  ExpectRefused(CheckFolder(path_, FolderRule::kPrivate), "has mode 0755, must have 0700");
}

TEST_F(PrivateFolder, IsUnsharedWhereOthersReadAndDoNotWrite) {
  for (const mode_t mode : {0700U, 0750U, 0755U, 0711U}) {
    MakeFolder(mode);
    EXPECT_TRUE(CheckFolder(path_, FolderRule::kUnshared).ok()) << std::oct << mode;
  }
  for (const mode_t mode : {0720U, 0702U, 0777U, 01777U}) {
    MakeFolder(mode);
    ExpectRefused(CheckFolder(path_, FolderRule::kUnshared), "has mode ");
  }
  ExpectRefused(CheckFolder(path_, FolderRule::kUnshared),
                "has mode 1777, must not be writable by its group or others");
}

TEST_F(PrivateFolder, IsNoLinkAndNoFile) {
  MakeFolder(0700);
  const std::string link = scratch_ / "link";
  ASSERT_EQ(symlink(path_.c_str(), link.c_str()), 0);
  for (const std::string& name : {link, link + "/", link + "//"}) {
    const absl::Status status = CheckFolder(name, FolderRule::kPrivate);
    EXPECT_TRUE(absl::IsPermissionDenied(status)) << status;
    EXPECT_THAT(std::string(status.message()),
                HasSubstr("is a symbolic link, must be a directory"));
  }
  EXPECT_TRUE(absl::IsPermissionDenied(MakePrivateFolder(link)));
  const std::string file = scratch_ / "file";
  std::ofstream(file) << "mine";
  EXPECT_THAT(std::string(MakePrivateFolder(file).message()), HasSubstr("is no directory"));
  EXPECT_THAT(std::string(MakePrivateFolder(scratch_ / "none/folder").message()),
              HasSubstr("cannot be made"));
}

TEST_F(PrivateFolder, BelongsToThisUser) {
  if (!testing::CanBecomeOtherUser()) GTEST_SKIP() << "only root can make a folder another user's";
  MakeFolder(0700);
  ASSERT_EQ(chown(path_.c_str(), testing::kNobody, testing::kNobody), 0);
  const std::string why = "belongs to user 65534, must belong to user 0";
  ExpectRefused(MakePrivateFolder(path_), why);
  ExpectRefused(CheckFolder(path_, FolderRule::kUnshared), why);
  // Root's is as good as one's own where it is unshared, and not where it shall be private.
  ASSERT_EQ(chmod(scratch_.path().c_str(), 0755), 0);
  testing::OtherUser user(testing::kNobody, [&] {
    return std::string(CheckFolder(scratch_.path(), FolderRule::kUnshared).ok() ? "ok, " : "no, ") +
           std::string(CheckFolder(scratch_.path(), FolderRule::kPrivate).message());
  });
  EXPECT_EQ(user.Result(),
            "ok, " + scratch_.path() + ": belongs to user 0, must belong to user 65534");
}

}  // namespace
}  // namespace cwm
