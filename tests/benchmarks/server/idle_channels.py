"""Opens channels to a server, makes one call over each, and leaves them idle.

idle_channels.py ADDRESS COUNT [SECONDS]
"""
import sys
import time

import grpc

ADDRESS, COUNT = sys.argv[1], int(sys.argv[2])
SECONDS = float(sys.argv[3]) if len(sys.argv) > 3 else 60.0
METHOD = "/cwm.v1.AdminService/GetServerInfo"

channels = [
    grpc.insecure_channel(ADDRESS, options=[("grpc.use_local_subchannel_pool", 1)])
    for _ in range(COUNT)
]
for channel in channels:
    channel.unary_unary(METHOD)(b"", timeout=20)
print("ready", flush=True)
time.sleep(SECONDS)
