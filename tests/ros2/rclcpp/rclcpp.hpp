// A stand-in for what examples/ros2 uses of ROS 2, which Debian does not have: parameters are arguments (-p name:=value), messages come from lines of
// standard input (t gx gy gz ax ay az), and what is published is printed.
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace rclcpp {

struct Time {};
struct QoS {
  explicit QoS(int) {}
};
struct SensorDataQoS : QoS {
  SensorDataQoS() : QoS(5) {}
};

inline std::map<std::string, std::string>& parameters() {
  static std::map<std::string, std::string> all;
  return all;
}
inline void init(int argc, char** argv) {
  for (int i = 1; i + 1 < argc; ++i)
    if (const std::string pair = argv[i + 1]; std::string(argv[i]) == "-p")
      parameters()[pair.substr(0, pair.find(":="))] = pair.substr(pair.find(":=") + 2);
}
inline void shutdown() {}

template <class Message>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher>;
  void publish(const Message& message) { print(message); }
};
struct AnySubscription {
  virtual ~AnySubscription() = default;
  virtual void deliver(const double* row) = 0;
};
template <class Message>
struct Subscription : AnySubscription {
  using SharedPtr = std::shared_ptr<Subscription>;
  std::function<void(typename Message::SharedPtr)> callback;
  void deliver(const double* row) override {
    if (const auto message = std::make_shared<Message>(); fill(*message, row)) callback(message);
  }
};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
  std::function<void()> callback;
};

class Node {
 public:
  explicit Node(const std::string&) {}
  template <class T>
  T declare_parameter(const std::string& name, T value) {
    const auto given = parameters().find(name);
    if (given == parameters().end()) return value;
    if constexpr (std::is_same_v<T, double>)
      return std::stod(given->second);
    else
      return given->second;
  }
  template <class Message>
  std::shared_ptr<Publisher<Message>> create_publisher(const std::string&, const QoS&) {
    return std::make_shared<Publisher<Message>>();
  }
  template <class Message, class Callback>
  std::shared_ptr<Subscription<Message>> create_subscription(const std::string&, const QoS&, Callback callback) {
    auto out = std::make_shared<Subscription<Message>>();
    out->callback = callback;
    subscriptions.push_back(out);
    return out;
  }
  template <class Period, class Callback>
  TimerBase::SharedPtr create_wall_timer(Period, Callback callback) {
    return timer = std::make_shared<TimerBase>(TimerBase{callback});
  }
  Time now() const { return {}; }

  std::vector<std::shared_ptr<AnySubscription>> subscriptions;
  TimerBase::SharedPtr timer;
};

inline void spin(const std::shared_ptr<Node>& node) {
  double row[7];
  while (std::scanf("%lf %lf %lf %lf %lf %lf %lf", &row[0], &row[1], &row[2], &row[3], &row[4], &row[5], &row[6]) == 7)
    for (const auto& subscription : node->subscriptions) subscription->deliver(row);
  node->timer->callback();
}

}  // namespace rclcpp
