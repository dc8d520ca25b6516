// A stage of tiny jobs, whose results are what they were made from and nothing else.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "block/stages/jobs.h"
#include "core/base/atomic_write.h"

namespace orient::block {

inline void WriteFakeResult(const ResultStore& store, const std::string& name,
                            const Inputs& inputs) {
  nlohmann::json made = {{"made_from", inputs}, {"result", name}};
  for (const auto& [input, value] : inputs)
    made["result"] = made["result"].get<std::string>() + " of " + value;
  WriteFileAtomically(store.PathOf(name), made.dump() + "\n");
}

// `before`: is called by the job first of all.
inline Job FakeJob(const ResultStore& store, const std::string& name, const Inputs& inputs,
                   const std::function<void()>& before = {}) {
  return {name, inputs, [=] {
            if (before) before();
            WriteFakeResult(store, name, inputs);
          }};
}

}  // namespace orient::block
