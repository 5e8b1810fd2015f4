# SPDX-License-Identifier: Apache-2.0
# Slurm's daemons on this machine alone, for tools/prove-farm. Sourced, not run.

# start_slurm FOLDER: configuration, logs and state live in FOLDER. Exports SLURM_CONF.
start_slurm() {
    local folder="$1" host
    host=$(hostname -s)
    mkdir -p "$folder/state" "$folder/spool" /run/munge
    [ -s /etc/munge/munge.key ] || dd if=/dev/urandom of=/etc/munge/munge.key bs=1 count=1024 status=none
    chown -R munge:munge /etc/munge /run/munge /var/lib/munge /var/log/munge
    chmod 400 /etc/munge/munge.key
    runuser -u munge -- /usr/sbin/munged --force
    export SLURM_CONF="$folder/slurm.conf"
    cat >"$SLURM_CONF" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ReturnToService=2
MinJobAge=3600
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(free -m | awk '/^Mem/ {print int($2 * 0.9)}') State=UNKNOWN
PartitionName=night Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
    slurmctld
    slurmd
    local tries=0
    until sinfo -h -o %T 2>/dev/null | grep -qE 'idle|mix'; do
        tries=$((tries + 1))
        [ $tries -lt 60 ] || { tail -n 20 "$folder"/slurm*.log >&2; echo "Slurm does not start" >&2; return 1; }
        sleep 0.5
    done
}

stop_slurm() {
    scontrol shutdown >/dev/null 2>&1
    pkill -u munge munged
}
