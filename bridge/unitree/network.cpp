#include "bridge/unitree/network.hpp"

#include <dds/dds.h>
#include <fmt/format.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <stdexcept>

#include "baton/model/error.hpp"
#include "low_level.h"

namespace baton::unitree {
namespace {

using WireCommand = unitree_hg_msg_dds__LowCmd_;
using WireState = unitree_hg_msg_dds__LowState_;
using WireRequest = unitree_api_msg_dds__Request_;
using WireResponse = unitree_api_msg_dds__Response_;

static_assert(sizeof(WireCommand) == sizeof(LowCommand) && sizeof(WireState) == sizeof(LowState));
static_assert(offsetof(WireCommand, crc) == offsetof(LowCommand, crc));
static_assert(offsetof(WireState, motor_state) == offsetof(LowState, motors));
static_assert(offsetof(WireState, wireless_remote) == offsetof(LowState, wireless_remote));

constexpr dds_domainid_t kDomain = 0;  ///< of the maker's computers
constexpr int kDepth = 16;             ///< states that are kept until they are read

const char* const kCommandTopic = "rt/lowcmd";
const char* const kStateTopic = "rt/lowstate";
const char* const kRequestTopic = "rt/api/motion_switcher/request";
const char* const kResponseTopic = "rt/api/motion_switcher/response";

/// @throws std::runtime_error `result` is an error
dds_return_t checked(dds_return_t result, const char* what) {
  if (result < 0) throw std::runtime_error(fmt::format("DDS: {}: {}", what, dds_strretcode(result)));
  return result;
}

/// How DDS is configured. Where nothing is said, its own environment variable CYCLONEDDS_URI holds.
std::string configuration(const std::string& interface) {
  if (interface.empty()) return "";
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("._-:", c) != nullptr;
  };
  if (!std::ranges::all_of(interface, plain) || if_nametoindex(interface.c_str()) == 0)
    throw InputError(fmt::format("--interface {}: this computer has no such network interface", interface));
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"{}\"/></Interfaces></General>"
      "</Domain></CycloneDDS>",
      interface);
}

/// A quality of service, deleted with it.
class Qos {
 public:
  Qos() : qos_(dds_create_qos()) {}
  ~Qos() { dds_delete_qos(qos_); }
  Qos(const Qos&) = delete;
  Qos& operator=(const Qos&) = delete;
  dds_qos_t* operator*() const { return qos_; }

 private:
  dds_qos_t* qos_;
};

/// A sample that is taken from a reader into memory of its own, zero where nothing is written.
template <typename Sample>
struct Taken {
  Sample sample{};
  dds_sample_info_t info{};

  /// @returns whether there was one with data
  bool from(dds_entity_t reader) {
    void* into = &sample;
    while (dds_take(reader, &into, &info, 1, 1) > 0) {
      if (info.valid_data) return true;  // else it tells that a publisher is gone
    }
    return false;
  }
};

}  // namespace

struct Network::Entities {
  dds_entity_t domain = 0;
  dds_entity_t participant = 0;
  dds_entity_t commands = 0;          ///< writer
  dds_entity_t foreign_commands = 0;  ///< reader
  dds_entity_t states = 0;            ///< reader
  dds_entity_t requests = 0;          ///< writer
  dds_entity_t responses = 0;         ///< reader
  dds_entity_t publications = 0;      ///< reader: who publishes what
  dds_entity_t waiting = 0;
  dds_instance_handle_t robot = 0;  ///< publisher of the states that are believed

  ~Entities() {
    if (participant > 0) dds_delete(participant);
    if (domain > 0) dds_delete(domain);
  }

  /// Whether a publisher of states is still there.
  bool publishes(dds_instance_handle_t publisher) const {
    dds_builtintopic_endpoint_t* const found = dds_get_matched_publication_data(states, publisher);
    if (found != nullptr) dds_builtintopic_free_endpoint(found);
    return found != nullptr;
  }

  dds_entity_t topic(const dds_topic_descriptor_t& descriptor, const char* name) const {
    return checked(dds_create_topic(participant, &descriptor, name, nullptr, nullptr), name);
  }

  dds_entity_t reader(dds_entity_t topic, int depth) const {
    const Qos qos;
    dds_qset_reliability(*qos, DDS_RELIABILITY_BEST_EFFORT, 0);  // goes with every kind of writer
    dds_qset_history(*qos, DDS_HISTORY_KEEP_LAST, depth);
    dds_qset_ignorelocal(*qos, DDS_IGNORELOCAL_PARTICIPANT);
    return checked(dds_create_reader(participant, topic, *qos, nullptr), "a reader");
  }

  dds_entity_t writer(dds_entity_t topic) const {
    const Qos qos;
    dds_qset_reliability(*qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(1));  // goes with every kind of reader
    dds_qset_history(*qos, DDS_HISTORY_KEEP_LAST, 1);
    return checked(dds_create_writer(participant, topic, *qos, nullptr), "a writer");
  }
};

Network::Network(const std::string& interface, Speaks speaks) : entities_(std::make_unique<Entities>()) {
  Entities& e = *entities_;
  const std::string configured = configuration(interface);
  if (!configured.empty()) e.domain = checked(dds_create_domain(kDomain, configured.c_str()), "its domain");
  e.participant = checked(dds_create_participant(kDomain, nullptr, nullptr), "its participant");
  const dds_entity_t commands = e.topic(unitree_hg_msg_dds__LowCmd__desc, kCommandTopic);
  e.foreign_commands = e.reader(commands, 1);
  e.states = e.reader(e.topic(unitree_hg_msg_dds__LowState__desc, kStateTopic), kDepth);
  if (speaks == Speaks::yes) {
    e.commands = e.writer(commands);
    e.requests = e.writer(e.topic(unitree_api_msg_dds__Request__desc, kRequestTopic));
  }
  e.responses = e.reader(e.topic(unitree_api_msg_dds__Response__desc, kResponseTopic), kDepth);
  e.publications = checked(dds_create_reader(e.participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
                           "the list of publishers");
  e.waiting = checked(dds_create_waitset(e.participant), "a wait set");
  for (const dds_entity_t reader : {e.states, e.foreign_commands}) {
    checked(dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS), "a status");
    checked(dds_waitset_attach(e.waiting, reader, reader), "a wait set");
  }
}

Network::~Network() = default;

void Network::wait(double limit) {
  std::array<dds_attach_t, 2> some{};
  checked(dds_waitset_wait(entities_->waiting, some.data(), some.size(),
                           static_cast<dds_duration_t>(1e9 * std::max(limit, 0.0))),
          "waiting");
}

std::optional<LowState> Network::state(const Complain& complain) {
  Entities& e = *entities_;
  while (true) {
    Taken<WireState> taken;
    if (!taken.from(e.states)) return std::nullopt;
    const dds_instance_handle_t publisher = taken.info.publication_handle;
    if (publisher != e.robot && !e.publishes(e.robot)) e.robot = publisher;
    if (publisher == e.robot) return std::bit_cast<LowState>(taken.sample);
    complain("a second publisher of rt/lowstate");
  }
}

bool Network::foreign_command() {
  bool any = false;
  Taken<WireCommand> taken;
  while (taken.from(entities_->foreign_commands))
    any = true;
  return any;
}

void Network::look_for_strangers(const Complain& complain) {
  void* some = nullptr;
  dds_sample_info_t info{};
  while (dds_take(entities_->publications, &some, &info, 1, 1) > 0) {
    const auto* const found = static_cast<const dds_builtintopic_endpoint_t*>(some);
    const auto stranger = [&](const char* topic, const char* type) {
      if (info.valid_data && std::strcmp(found->topic_name, topic) == 0 && std::strcmp(found->type_name, type) != 0)
        complain(fmt::format("a publisher of {} whose type is not {}", topic, type));
    };
    stranger(kStateTopic, unitree_hg_msg_dds__LowState__desc.m_typename);
    stranger(kCommandTopic, unitree_hg_msg_dds__LowCmd__desc.m_typename);
    stranger(kResponseTopic, unitree_api_msg_dds__Response__desc.m_typename);
    dds_return_loan(entities_->publications, &some, 1);
    some = nullptr;
  }
}

void Network::send(const LowCommand& command) {
  const auto wire = std::bit_cast<WireCommand>(command);
  const dds_return_t result = dds_write(entities_->commands, &wire);
  if (result != DDS_RETCODE_TIMEOUT) checked(result, kCommandTopic);  // the next one follows soon
}

void Network::send(const FactoryGait::Request& request) {
  std::string nothing = "{}";
  WireRequest wire{};
  wire.header.identity.id = request.id;
  wire.header.identity.api_id = static_cast<std::int64_t>(request.api);
  wire.parameter = nothing.data();
  const dds_return_t result = dds_write(entities_->requests, &wire);
  if (result != DDS_RETCODE_TIMEOUT) checked(result, kRequestTopic);
}

std::optional<Network::Answer> Network::answer() {
  Taken<WireResponse> taken;
  std::optional<Answer> answer;
  if (taken.from(entities_->responses)) {
    answer = Answer{taken.sample.header.identity.id, taken.sample.header.status.code,
                    taken.sample.data != nullptr ? taken.sample.data : ""};
  }
  dds_sample_free(&taken.sample, &unitree_api_msg_dds__Response__desc, DDS_FREE_CONTENTS);
  return answer;
}

}  // namespace baton::unitree
