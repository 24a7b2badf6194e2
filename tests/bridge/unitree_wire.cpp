/// A participant on the network of a Unitree robot that says what it is told, byte by byte: the robot, or somebody who
/// does not belong there. Frames on standard input:
///
///     S <2092 bytes>                            publishes a state on rt/lowstate
///     C <1004 bytes>                            publishes a command on rt/lowcmd
///     A <id 8><code 4><length 4><text>          answers as the motion switcher
///
/// and on standard output:
///
///     c <1004 bytes>                            a command has come
///     q <id 8><api 8>                           the motion switcher was asked
///
/// With --wrong-type it publishes commands on rt/lowstate instead, which S then does.
#include <dds/dds.h>
#include <poll.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "low_level.h"

namespace {

using Command = unitree_hg_msg_dds__LowCmd_;
using State = unitree_hg_msg_dds__LowState_;
using Request = unitree_api_msg_dds__Request_;
using Response = unitree_api_msg_dds__Response_;

dds_entity_t checked(dds_entity_t entity) {
  if (entity < 0) throw std::runtime_error(dds_strretcode(entity));
  return entity;
}

class Wire {
 public:
  explicit Wire(bool wrong_type)
      : participant_(checked(dds_create_participant(0, nullptr, nullptr))),
        states_(
            writer(wrong_type ? unitree_hg_msg_dds__LowCmd__desc : unitree_hg_msg_dds__LowState__desc, "rt/lowstate")),
        answers_(writer(unitree_api_msg_dds__Response__desc, "rt/api/motion_switcher/response")),
        questions_(reader(unitree_api_msg_dds__Request__desc, "rt/api/motion_switcher/request")) {
    // Not its own commands.
    dds_qos_t* qos = dds_create_qos();
    dds_qset_ignorelocal(qos, DDS_IGNORELOCAL_PARTICIPANT);
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 16);
    const dds_entity_t commands =
        checked(dds_create_topic(participant_, &unitree_hg_msg_dds__LowCmd__desc, "rt/lowcmd", nullptr, nullptr));
    heard_ = checked(dds_create_reader(participant_, commands, qos, nullptr));
    commands_ = checked(dds_create_writer(participant_, commands, nullptr, nullptr));
    dds_delete_qos(qos);
  }
  ~Wire() { dds_delete(participant_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  /// @returns bytes of a whole frame that was done; 0: there is none yet
  std::size_t obey(std::string_view bytes) {
    if (bytes.empty()) return 0;
    if (bytes[0] == 'S') return publish<State>(states_, bytes.substr(1));
    if (bytes[0] == 'C') return publish<Command>(commands_, bytes.substr(1));
    if (bytes[0] != 'A') throw std::runtime_error("no frame");
    constexpr std::size_t kHead = 16;
    if (bytes.size() < 1 + kHead) return 0;
    Response response{};
    std::uint32_t length = 0;
    std::memcpy(&response.header.identity.id, bytes.data() + 1, 8);
    std::memcpy(&response.header.status.code, bytes.data() + 9, 4);
    std::memcpy(&length, bytes.data() + 13, 4);
    if (bytes.size() < 1 + kHead + length) return 0;
    std::string text(bytes.substr(1 + kHead, length));
    response.data = text.data();
    checked(dds_write(answers_, &response));
    return 1 + kHead + length;
  }

  void report() {
    Command command{};
    while (take(heard_, command)) {
      std::fputc('c', stdout);
      std::fwrite(&command, sizeof(command), 1, stdout);
    }
    Request request{};
    while (take(questions_, request)) {
      std::fputc('q', stdout);
      std::fwrite(&request.header.identity.id, 8, 1, stdout);
      std::fwrite(&request.header.identity.api_id, 8, 1, stdout);
    }
    std::fflush(stdout);
  }

 private:
  dds_entity_t writer(const dds_topic_descriptor_t& type, const char* name) const {
    return checked(dds_create_writer(
        participant_, checked(dds_create_topic(participant_, &type, name, nullptr, nullptr)), nullptr, nullptr));
  }
  dds_entity_t reader(const dds_topic_descriptor_t& type, const char* name) const {
    return checked(dds_create_reader(
        participant_, checked(dds_create_topic(participant_, &type, name, nullptr, nullptr)), nullptr, nullptr));
  }

  template <typename Sample>
  static std::size_t publish(dds_entity_t writer, std::string_view bytes) {
    if (bytes.size() < sizeof(Sample)) return 0;
    Sample sample;
    std::memcpy(&sample, bytes.data(), sizeof(sample));
    checked(dds_write(writer, &sample));
    return 1 + sizeof(sample);
  }

  template <typename Sample>
  static bool take(dds_entity_t reader, Sample& sample) {
    void* into = &sample;
    dds_sample_info_t info{};
    while (dds_take(reader, &into, &info, 1, 1) > 0) {
      if (info.valid_data) return true;
    }
    return false;
  }

  dds_entity_t participant_;
  dds_entity_t states_;
  dds_entity_t answers_;
  dds_entity_t questions_;
  dds_entity_t heard_ = 0;
  dds_entity_t commands_ = 0;
};

}  // namespace

int main(int argc, char** argv) try {
  Wire wire(argc > 1 && std::string_view(argv[1]) == "--wrong-type");
  std::string bytes;
  while (true) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 1) > 0) {
      char some[1U << 16U];
      const ssize_t got = read(STDIN_FILENO, some, sizeof(some));
      if (got <= 0) return 0;
      bytes.append(some, static_cast<std::size_t>(got));
      while (const std::size_t done = wire.obey(bytes))
        bytes.erase(0, done);
    }
    wire.report();
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
