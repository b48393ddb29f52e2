import sys
from pathlib import Path
from parts.concealed.case_folder import read_case
from exidyn.identification.diagnosis import diagnose
from exidyn.identification.preparation.prepare import Filtering
runs=read_case(Path(sys.argv[1])); roles=[(r.settings['role'],r) for r in runs]
d=diagnose(runs[0].model,roles,filtering=Filtering(torque_cutoff=25.0))
print(d); print('NAMED',[(f.effect,f.joints,round(f.probability,4)) for f in d.findings])
for f in d.undecided: print('open',f.effect,f.joints,round(f.probability,4),'proven',f.proven,'alone',f.alone,'held',round(f.held_out,1),'rms',f.torque_rms.round(3),[(a.effect,a.joints,round(a.probability,3)) for a in f.alternatives][:4], f)
print(d.adequacy, d.beliefs)
