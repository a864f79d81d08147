#!/usr/bin/env python3
"""skein adapt over two hosts that talk TCP gives a valid mesh, byte for byte that of one host.

The hosts are two network namespaces of this machine, joined by a pair of virtual interfaces. They reach each other and
nothing else. Without the right to make namespaces the test is skipped (exit code 77).
"""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "app"))
import runner

SKIPPED = 77
LINK = "skein0"  # the name of the interface on both hosts
PREFIX = "skein-test-"
ADDRESSES = ("192.0.2.1", "192.0.2.2")  # reserved for documentation: nobody else has them


def run(*command, check=True, **options):
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if check and done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def remove_leftovers():
    """Namespaces of tests that were killed."""
    for line in run("ip", "netns", "list").stdout.splitlines():
        name = line.split()[0]
        if name.startswith(PREFIX) and not Path(f"/proc/{name.split('-')[2]}").exists():
            run("ip", "netns", "delete", name, check=False)


class Hosts:
    """Two namespaces with an address each, and a common folder. Removed by close(), also after SIGTERM and SIGINT."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory(prefix="skein-hosts-")
        self.names = [f"{PREFIX}{os.getpid()}-{k}" for k in "ab"]
        ends = [f"skein{os.getpid()}{k}"[-15:] for k in "ab"]
        try:
            remove_leftovers()
            for name in self.names:
                run("ip", "netns", "add", name)
            run("ip", "link", "add", ends[0], "netns", self.names[0], "type", "veth", "peer", "name", ends[1],
                "netns", self.names[1])
            for name, end, address in zip(self.names, ends, ADDRESSES):
                run("ip", "-n", name, "link", "set", end, "name", LINK)
                run("ip", "-n", name, "address", "add", address + "/30", "dev", LINK)
                run("ip", "-n", name, "link", "set", LINK, "up")
                run("ip", "-n", name, "link", "set", "lo", "up")
            run("ip", "netns", "exec", self.names[0], "true")
            run("unshare", "--uts", "true")
        except BaseException:
            self.close()
            raise

    def close(self):
        for name in self.names:
            for pid in run("ip", "netns", "pids", name, check=False).stdout.split():
                os.kill(int(pid), signal.SIGKILL)
            run("ip", "netns", "delete", name, check=False)
        self.folder.cleanup()

    def inside(self, host):
        """Prefix of a command that runs on this host."""
        return ["ip", "netns", "exec", self.names[host], "unshare", "--uts", "sh", "-c",
                f'hostname {self.names[host]}; exec "$@"', "sh"]

    def received(self, host):
        """Bytes that came in over the link."""
        path = f"/sys/class/net/{LINK}/statistics/rx_bytes"
        return int(run(*self.inside(host), "cat", path).stdout)


def mpirun(hosts, per_host, over, command, folder):
    """Runs it on 2 * per_host ranks over one host or two, TCP between ranks; its standard output."""
    wanted = [f"{ADDRESSES[h]}:{2 * per_host // over}" for h in range(over)]
    environment = dict(os.environ, SKEIN_TEST_HOSTS=" ".join(f"{a}={n}" for a, n in zip(ADDRESSES, hosts.names)),
                       OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", TMPDIR=folder)
    launch = ["mpirun", "--host", ",".join(wanted), "-n", str(2 * per_host), "--bind-to", "none",
              "--mca", "plm", "rsh", "--mca", "plm_rsh_agent", str(HERE / "rsh_agent.sh"),
              "--mca", "btl", "tcp,self", "--mca", "pml", "ob1",
              "--mca", "btl_tcp_if_include", LINK if over == 2 else "lo", "--mca", "oob_tcp_if_include", LINK,
              "--mca", "mpi_yield_when_idle", "1"]
    return run(*hosts.inside(0), *launch, *command, env=environment, timeout=100).stdout


class TwoHosts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(HOSTS.folder.name)
        verts, tets, tris = runner.cube(5)
        runner.write_mesh(cls.folder / "in.mesh", verts, tets, tris)
        runner.write_solution(cls.folder / "in.sol", [(0.05 + 0.1 * abs(x - 0.4),) for x, _, _ in verts])

    def adapt(self, per_host, over):
        output = self.folder / f"out-{per_host}-{over}.meshb"
        command = [runner.SKEIN, "adapt", self.folder / "in.mesh", "--size", self.folder / "in.sol", "-o", output]
        mpirun(HOSTS, per_host, over, [str(c) for c in command], str(self.folder))
        return output

    def check_ranks(self, per_host):
        before = [HOSTS.received(h) for h in (0, 1)]
        two = self.adapt(per_host, 2)
        for host in (0, 1):
            self.assertGreater(HOSTS.received(host) - before[host], 100000, "the hosts hardly talked")
        done = runner.run(1, "check", two)
        self.assertEqual(done.code, 0, done.out + done.err)
        self.assertEqual(two.read_bytes(), self.adapt(per_host, 1).read_bytes(), "one host gives another mesh")

    def test_ranks_are_on_both_hosts(self):
        names = mpirun(HOSTS, 2, 2, ["hostname"], str(self.folder)).split()
        self.assertEqual(sorted(names), sorted(2 * HOSTS.names))

    def test_one_rank_on_each(self):
        self.check_ranks(1)

    def test_two_ranks_on_each(self):
        self.check_ranks(2)

    def test_an_error_ends_all_ranks(self):
        with self.assertRaisesRegex(RuntimeError, "exit code 3"):
            mpirun(HOSTS, 1, 2, [runner.SKEIN, "adapt", str(self.folder / "missing.mesh"), "--size", "missing.sol",
                                 "-o", str(self.folder / "never.meshb")], str(self.folder))


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


if __name__ == "__main__":
    for tool in ("ip", "unshare", "hostname", "mpirun"):
        if shutil.which(tool) is None:
            skip(f"{tool} is missing (Debian: iproute2, util-linux, hostname, openmpi-bin)")
    if "Open MPI" not in run("mpirun", "--version").stdout:
        skip("the launcher is not Open MPI's")
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # unittest lets KeyboardInterrupt through, not SystemExit
    try:
        HOSTS = Hosts()
    except RuntimeError as e:
        skip("network namespaces are not permitted here: " + str(e).strip().replace("\n", " "))
    try:
        unittest.main()
    finally:
        HOSTS.close()
