#include "server/core/fair_tasks.h"

#include <gtest/gtest.h>

#include <string>

namespace cwm::server {
namespace {

Task Of(std::int64_t connection, double cost_s) {
  Task task;
  task.run = [](const absl::Status&) {};
  task.client = {.connection = connection, .uid = {}};
  task.cost_s = cost_s;
  return task;
}

// The clients' connections in the order in which their tasks are served.
std::string Order(FairTasks& tasks) {
  std::string order;
  while (!tasks.empty()) order += std::to_string(tasks.Pop().client.connection);
  return order;
}

TEST(FairTasks, ServesOneClientInItsOwnOrder) {
  FairTasks tasks;
  for (int i = 0; i < 3; ++i) {
    Task task = Of(1, 1.0 / (1 + i));
    task.deadline = Clock::time_point(std::chrono::seconds(i));
    tasks.Push(std::move(task));
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(tasks.Pop().deadline, Clock::time_point(std::chrono::seconds(i)));
  }
}

TEST(FairTasks, KeepTheOrderOfAClientWhoseTasksAreCheaperThanEstimated) {
  FairTasks tasks;
  const auto push = [&](int number) {
    Task task = Of(1, 1);
    task.deadline = Clock::time_point(std::chrono::seconds(number));
    tasks.Push(std::move(task));
  };
  const auto pop = [&] { return tasks.Pop().deadline - Clock::time_point(); };
  push(0), push(1), push(2);
  EXPECT_EQ(pop(), std::chrono::seconds(0));
  tasks.Correct({.connection = 1, .uid = {}}, -0.9);
  tasks.Correct({.connection = 1, .uid = {}}, -0.9);
  tasks.Correct({.connection = 1, .uid = {}}, -0.9);
  push(3);
  for (int number = 1; number <= 3; ++number) EXPECT_EQ(pop(), std::chrono::seconds(number));
}

TEST(FairTasks, DelaysANewcomerByOneTaskOfACrowd) {
  FairTasks tasks;
  for (int i = 0; i < 5; ++i) tasks.Push(Of(1, 1));
  EXPECT_EQ(tasks.Pop().client.connection, 1);
  tasks.Push(Of(2, 1));
  EXPECT_EQ(Order(tasks), "21111");
}

TEST(FairTasks, SharesByCostNotByCount) {
  FairTasks tasks;
  for (int i = 0; i < 2; ++i) tasks.Push(Of(1, 4));
  for (int i = 0; i < 6; ++i) tasks.Push(Of(2, 1));
  EXPECT_EQ(Order(tasks), "12222122");
}

TEST(FairTasks, WhatCostMoreThanEstimatedIsPaidByTheNextOnes) {
  FairTasks tasks;
  tasks.Push(Of(1, 1));
  EXPECT_EQ(tasks.Pop().client.connection, 1);
  tasks.Correct({.connection = 1, .uid = {}}, 3);
  for (int i = 0; i < 2; ++i) tasks.Push(Of(1, 1));
  for (int i = 0; i < 6; ++i) tasks.Push(Of(2, 1));
  EXPECT_EQ(Order(tasks), "22221212");
  tasks.Correct({.connection = 2, .uid = {}}, -3);
  for (const int connection : {1, 2}) tasks.Push(Of(connection, 1));
  EXPECT_EQ(Order(tasks), "21");
}

TEST(FairTasks, OwesNothingToWhoWasIdle) {
  FairTasks tasks;
  for (int i = 0; i < 4; ++i) tasks.Push(Of(1, 1));
  EXPECT_EQ(Order(tasks), "1111");
  tasks.Push(Of(1, 1));
  tasks.Push(Of(2, 1));
  tasks.Push(Of(1, 1));
  tasks.Push(Of(2, 1));
  EXPECT_EQ(Order(tasks), "2121") << "the one that had its turns comes second, and not fifth";
}

TEST(FairTasks, MakesRoomFromTheLongestQueueAlone) {
  FairTasks tasks;
  for (int i = 0; i < 3; ++i) tasks.Push(Of(1, 1));
  tasks.Push(Of(2, 1));
  EXPECT_FALSE(tasks.TakeFromLongest({.connection = 1, .uid = {}})) << "not from the others";
  const auto longest = tasks.TakeFromLongest({.connection = 3, .uid = {}});
  ASSERT_TRUE(longest);
  EXPECT_EQ(longest->client.connection, 1);
  tasks.Push(Of(3, 1));
  EXPECT_FALSE(tasks.TakeFromLongest({.connection = 3, .uid = {}})) << "it would have as many";
  EXPECT_EQ(Order(tasks), "1231");
}

TEST(FairTasks, TellsWhatIsServedBeforeANewcomer) {
  FairTasks tasks;
  for (int i = 0; i < 3; ++i) tasks.Push(Of(1, 2));
  EXPECT_DOUBLE_EQ(tasks.CostBefore({.connection = 1, .uid = {}}), 6);
  EXPECT_DOUBLE_EQ(tasks.CostBefore({.connection = 2, .uid = {}}), 2);
}

}  // namespace
}  // namespace cwm::server
