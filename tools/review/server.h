// The review on 127.0.0.1, for this machine's browser alone.
#pragma once

#include <functional>
#include <string>

#include "tools/review/review.h"

namespace orient {

// Serves until the process ends. `port` 0: one that is free. `ready` gets the page's address when
// it can be asked for. Throws UsageError where the port is taken.
void ServeReview(Review* review, int port,
                 const std::function<void(const std::string& address)>& ready);

}  // namespace orient
