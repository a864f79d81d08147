#!/bin/sh
# Open MPI's way to another host, where the hosts are network namespaces: rsh_agent.sh HOST COMMAND...
# SKEIN_TEST_HOSTS holds address=namespace pairs. Each host gets a name of its own, too: Open MPI goes by names.
host=$1
shift
for pair in $SKEIN_TEST_HOSTS; do
  if [ "${pair%%=*}" = "$host" ]; then
    namespace=${pair#*=}
    exec ip netns exec "$namespace" unshare --uts sh -c "hostname $namespace; $*"
  fi
done
echo "rsh_agent.sh: no host $host among: $SKEIN_TEST_HOSTS" >&2
exit 1
