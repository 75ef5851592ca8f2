// Collects warnings that concern several objects.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace cwm::server {

// Each note with the objects that it is about; it is written once, with the first few names.
class Notes {
 public:
  // Objects must come one after the other: repeated calls for one object count once.
  void Add(const std::string& note, const std::string& object);
  // Appends "a, b and 4 more: what became of them", in the order of the notes.
  void AppendTo(std::vector<std::string>& warnings) const;

 private:
  std::map<std::string, std::vector<std::string>> objects_of_note_;
};

}  // namespace cwm::server
