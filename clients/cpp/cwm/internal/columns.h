// Columns of several replies as those of one.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "cwm/error.h"
#include "cwm/results.h"
#include "cwm/v1/query.pb.h"

namespace cwm::CWM_API::internal {

// Joins the columns of the replies to a query. `count(reply)` is the number of entries of a reply.
template <class Reply>
class Columns {
 public:
  template <class Count>
  Columns(const std::vector<Reply>& replies, const Count& count) : replies_(replies) {
    for (const Reply& reply : replies) {
      counts_.push_back(static_cast<Eigen::Index>(count(reply)));
      total_ += counts_.back();
    }
  }

  Eigen::Index total() const { return total_; }

  // `get(reply)` returns the bytes of a column; empty: all entries are `absent`.
  template <class Get>
  Eigen::VectorXd Doubles(const Get& get, double absent = 0) const {
    Eigen::VectorXd column(total_);
    Read<double>(get, 1, absent, column.data());
    return column;
  }
  template <class Get>
  Eigen::VectorXi Ints(const Get& get) const {
    Eigen::VectorXi column(total_);
    Read<int>(get, 1, kNothing, column.data());
    return column;
  }
  template <class Get>
  Eigen::Matrix3Xd Vectors(const Get& get) const {
    Eigen::Matrix3Xd column(3, total_);
    Read<double>(get, 3, 0, column.data());
    return column;
  }
  template <class Get>
  Eigen::MatrixXd Matrix(const Get& get, Eigen::Index height) const {
    Eigen::MatrixXd column(height, total_);
    Read<double>(get, height, 0, column.data());
    return column;
  }
  // Enums of one byte.
  template <class Enum, class Get>
  std::vector<Enum> Bytes(const Get& get) const {
    static_assert(sizeof(Enum) == 1);
    std::vector<Enum> column(static_cast<std::size_t>(total_));
    Read<Enum>(get, 1, Enum{}, column.data());
    return column;
  }
  template <class Get>
  std::vector<bool> Bools(const Get& get) const {
    const std::vector<std::uint8_t> bytes = Bytes<std::uint8_t>(get);
    return {bytes.begin(), bytes.end()};
  }

 private:
  template <class T, class Get>
  void Read(const Get& get, Eigen::Index height, T absent, T* out) const {
    for (std::size_t i = 0; i < replies_.size(); ++i) {
      const auto count = static_cast<std::size_t>(counts_[i] * height);
      const std::string& bytes = get(replies_[i]);
      if (bytes.empty()) {
        std::fill_n(out, count, absent);
      } else if (bytes.size() < count * sizeof(T)) {
        throw Error(ErrorCode::kDataLoss, absl::StrCat("a column has ", bytes.size(),
                                                       " bytes, must have ", count * sizeof(T)));
      } else if (count > 0) {
        std::memcpy(out, bytes.data(), count * sizeof(T));
      }
      out += count;
    }
  }

  const std::vector<Reply>& replies_;
  std::vector<Eigen::Index> counts_ = {};
  Eigen::Index total_ = 0;
};

template <class Reply>
Columns<Reply> ColumnsOfRows(const std::vector<Reply>& replies) {
  return {replies, [](const Reply& reply) { return reply.completed_count(); }};
}

AnsweredObject FromMessage(const v1::ObjectRef& object);

// The objects of all replies by name, and where those of each reply are among them.
class MergedObjects {
 public:
  template <class Reply>
  explicit MergedObjects(const std::vector<Reply>& replies) {
    std::map<std::string, const v1::ObjectRef*> by_name;
    for (const Reply& reply : replies) {
      for (const v1::ObjectRef& object : reply.objects()) by_name[object.name()] = &object;
    }
    std::map<std::string, int> place;
    for (const auto& [name, object] : by_name) {
      place[name] = static_cast<int>(objects_.size());
      objects_.push_back(FromMessage(*object));
    }
    for (const Reply& reply : replies) {
      std::vector<int>& places = places_.emplace_back();
      for (const v1::ObjectRef& object : reply.objects()) places.push_back(place[object.name()]);
    }
  }

  std::vector<AnsweredObject> Take() { return std::move(objects_); }
  // Renumbers the entries of a reply in the joined column, from `begin` on.
  void Renumber(std::size_t reply, Eigen::Index begin, Eigen::Index count,
                Eigen::VectorXi& column) const;

 private:
  std::vector<AnsweredObject> objects_ = {};
  std::vector<std::vector<int>> places_ = {};
};

// The members that all answers share, and the column of object indices; `index(reply)` returns its
// bytes and `count(reply)` its number of entries.
template <class Reply, class Index, class Count>
Eigen::VectorXi FillHead(const std::vector<Reply>& replies, Eigen::Index row_count,
                         const Index& index, const Count& count, ResultHead& head) {
  head.row_count = row_count;
  for (const Reply& reply : replies) {
    head.completed_count += static_cast<Eigen::Index>(reply.completed_count());
  }
  if (!replies.empty()) {
    head.world_uid = replies.front().world_uid();
    head.revision = replies.front().revision();
  }
  MergedObjects objects(replies);
  Eigen::VectorXi column = Columns<Reply>(replies, count).Ints(index);
  Eigen::Index begin = 0;
  for (std::size_t i = 0; i < replies.size(); ++i) {
    const auto size = static_cast<Eigen::Index>(count(replies[i]));
    objects.Renumber(i, begin, size, column);
    begin += size;
  }
  head.objects = objects.Take();
  return column;
}

// Joins the columns `row_begin(reply)` of uint32.
template <class Reply, class Get>
std::vector<Eigen::Index> JoinRowBegins(const std::vector<Reply>& replies, const Get& get) {
  std::vector<Eigen::Index> begins = {0};
  for (const Reply& reply : replies) {
    const std::string& bytes = get(reply);
    const Eigen::Index before = begins.back();
    for (std::size_t i = 1; i < bytes.size() / sizeof(std::uint32_t); ++i) {
      std::uint32_t begin = 0;
      std::memcpy(&begin, bytes.data() + i * sizeof(begin), sizeof(begin));
      begins.push_back(before + static_cast<Eigen::Index>(begin));
    }
  }
  return begins;
}

// The last entry of a column of uint32; 0 if it is empty.
Eigen::Index LastBegin(const std::string& row_begin);

}  // namespace cwm::CWM_API::internal
